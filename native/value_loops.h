/* The values of a group of paths of one material, one step at a time over all of them. Included once a variant. */
#pragma once
#include "shadow_rays.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* Room for the registers that the scene's materials use. */
static void make_registers(Batch &b, Scene s) {
  b.registers.resize(size_t(s.world[0].registers) * CAPACITY);
  b.shadow_registers.resize(b.registers.size());
}

/* The registers of a path. */
static const real *registers_at(const Batch &b, uint i) { return b.registers.data() + i; }

/* Functions of their own: inlined into one, the loops are too many for the vectoriser. */
#define VALUE_LOOPS(number, name, inputs, outputs)                                            \
  FN_APART void compute_##name(Batch &__restrict b, real *__restrict registers, Scene s, Group g, ValueStep o, uint k) { \
    Columns columns = b.columns();                                                            \
    FOR_PATHS(i, g.first, g.end) value_##name(s, o, load_point(b, columns, i), registers + i, k); \
  }
VALUES(VALUE_LOOPS)
#undef VALUE_LOOPS

/* Steps that ask where the object is: path by path in groups that have something that moves. */
FN bool asks_object(int op) {
  switch (op) {
#define X(number) case number:
    OBJECT_VALUES(X)
#undef X
    return true;
    default: return false;
  }
}

static void run_moving_step(Batch &__restrict b, Scene s, Group g, ValueStep o, uint k) {
  Columns columns = b.columns();
  for (uint i = g.first; i < g.end; i++) run_step(s, o, in_its_time(s, load_point(b, columns, i)), b.registers.data() + i, k);
}

static bool any_moves(const Batch &b, Scene s, Group g) {
  uint features = s.world[0].features;
  if (!(features & FEATURE_MOTION)) return false;
  for (uint i = g.first; i < g.end; i++)
    if (is_moving(s, b.hit_instance[i], features)) return true;
  return false;
}

static void run_values(Batch &__restrict b, Scene s, Material m, Group g) {
  bool moves = any_moves(b, s, g);
  for (uint n = 0; n < m.steps; n++) {
    ValueStep o = s.steps[m.first_step + n];
    bool one_by_one = moves && asks_object(o.op);
    for (uint k = 0; k < o.repeat; k++) {
      if (one_by_one) {
        run_moving_step(b, s, g, o, k);
        continue;
      }
      switch (o.op) {
#define X(number, name, inputs, outputs) \
  case number: compute_##name(b, b.registers.data(), s, g, o, k); break;
        VALUES(X)
#undef X
      }
    }
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
