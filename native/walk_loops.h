/* The ways of light below surfaces: all paths of a batch that are inside an object fly together, a flight a loop, until
 * each has come out or is lost. Included once a variant. Values and arithmetic are those of kernels/walk.h. */
#pragma once
#include "shade_loops.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

#define WALKER_REALS(X)                                                                       \
  X(origin.x) X(origin.y) X(origin.z) X(direction.x) X(direction.y) X(direction.z)            \
  X(weight.x) X(weight.y) X(weight.z) X(depth) X(opposite)
#define FLIGHT_REALS(X) X(direction.x) X(direction.y) X(direction.z) X(length) X(phase) X(roulette)

/* Walkers of a thread, in structures of arrays; where one has left, the last takes its place. */
struct Walkers {
  alignas(64) real media[MEDIUM_COLUMNS][CAPACITY];
  alignas(64) real walkers[11][CAPACITY], flights[6][CAPACITY];
  alignas(64) uint path[CAPACITY], seed[CAPACITY], index[CAPACITY];
  alignas(64) real t[CAPACITY], u[CAPACITY], v[CAPACITY];
  alignas(64) uint instance[CAPACITY], primitive[CAPACITY];
  alignas(64) int state[CAPACITY];
  uint count = 0;
};

FN Medium medium_at(const Walkers &w, uint i) { return load_medium(&w.media[0][0], CAPACITY, i); }

FN Walker walker_at(const Walkers &w, uint i) {
  Walker r;
  uint n = 0;
#define X(field) r.field = w.walkers[n++][i];
  WALKER_REALS(X)
#undef X
  return r;
}

FN void store_walker(Walkers &__restrict w, uint i, const Walker &r) {
  uint n = 0;
#define X(field) w.walkers[n++][i] = r.field;
  WALKER_REALS(X)
#undef X
}

FN Flight flight_at(const Walkers &w, uint i) {
  Flight f;
  uint n = 0;
#define X(field) f.field = w.flights[n++][i];
  FLIGHT_REALS(X)
#undef X
  return f;
}

FN Hit hit_at(const Walkers &w, uint i) {
  Hit h;
  h.t = w.t[i];
  h.u = w.u[i];
  h.v = w.v[i];
  h.instance = w.instance[i];
  h.primitive = w.primitive[i];
  return h;
}

/* The rays of a flight. */
struct FlightRays {
  Walkers &w;
  Columns columns;
  uint number;
  Ray ray(uint i) const {
    return ray_of_flight(path_at(columns, w.path[i]), medium_at(w, i), walker_at(w, i), flight_at(w, i), number);
  }
  void store(uint i, const Hit &h) {
    w.t[i] = h.t;
    w.u[i] = h.u;
    w.v[i] = h.v;
    w.instance[i] = h.instance;
    w.primitive[i] = h.primitive;
  }
};

static void draw_flights(Walkers &__restrict w, uint number) {
  FOR_PATHS(i, 0, w.count) {
    Flight f = draw_flight(medium_at(w, i), walker_at(w, i), number, w.seed[i], w.index[i]);
    uint n = 0;
#define X(field) w.flights[n++][i] = f.field;
    FLIGHT_REALS(X)
#undef X
  }
}

static void end_flights(Walkers &__restrict w, uint number) {
  FOR_PATHS(i, 0, w.count) {
    Flown r = fly(medium_at(w, i), walker_at(w, i), flight_at(w, i), hit_at(w, i), number);
    store_walker(w, i, r.walker);
    w.state[i] = r.state;
  }
}

/* The path of a walk that has ended, and its hit. The last walker takes its place: one that goes on, whose flight and hit
 * are made anew. */
static void leave_walk(Batch &b, Walkers &w, uint i) {
  Columns columns = b.columns();
  uint at = w.path[i];
  Hit h = hit_at(w, i);
  Path p = path_at_exit(path_at(columns, at), walker_at(w, i), h, w.state[i]);
  store_path(columns.reals, columns.uints, CAPACITY, at, p);
  store_hit(b, at, w.state[i] == WALK_LOST ? no_hit(FAR_AWAY) : h);
  uint last = --w.count;
  for (auto &column : w.media) column[i] = column[last];
  for (auto &column : w.walkers) column[i] = column[last];
  for (uint *column : {w.path, w.seed, w.index}) column[i] = column[last];
}

/* What light wanders in where an instruction k was chosen. */
template <bool VARIES>
static void enter_media(Batch &__restrict b, Group g, Bound c, uint k) {
  Columns columns = b.columns();
  const real *registers = b.registers.data();
  real *__restrict media = b.media.data();
  FOR_PATHS(i, g.first, g.end) {
    Path p = path_at(columns, i);
    Entrance e = make_entrance(closure_at<VARIES>(b, c, registers, i), shading_normal(b, i));
    if (b.chosen[i] == int(k)) {
      store_medium(media, CAPACITY, i, e.medium);
      store_path(columns.reals, columns.uints, CAPACITY, i, with_throughput(p, path_throughput(p) * e.weight));
    }
  }
}

/* Gives those of the shaded paths that have gone below a surface their media. */
static void enter_objects(Batch &__restrict b, Scene s, const std::vector<Group> &groups) {
  for (Group g : groups) {
    if (g.material == MISS || g.material == SCATTERED_BY_VOLUMES || g.meeting != SCATTERS || !(s.materials[g.material].flags & MATERIAL_SUBSURFACE)) continue;
    Material m = s.materials[g.material];
    for (uint k = 0; k < m.count; k++) {
      Bound c = bind_instruction(b, s.instructions[m.first + k]);
      if (c.i.op != OP_SUBSURFACE) continue;
      RUN(enter_media, b, g, c, k);
    }
  }
}

/* Takes the batch's paths that are inside an object to where they come out; their media are those of the batch. */
static void walk_batch(Batch &b, Scene s, Walkers &w) {
  Columns columns = b.columns();
  w.count = 0;
  for (uint i = 0; i < b.count; i++) {
    if (!b.alive[i]) continue;
    Path p = path_at(columns, i);
    if (!is_inside(p)) continue;
    uint k = w.count++;
    store_medium(&w.media[0][0], CAPACITY, k, load_medium(b.media.data(), CAPACITY, i));
    store_walker(w, k, start_walker(p));
    w.path[k] = i;
    w.seed[k] = p.seed;
    w.index[k] = p.index;
  }
  for (uint number = 0; w.count > 0; number++) {
    draw_flights(w, number);
    FlightRays rays{w, columns, number};
    b.closest += w.count;
    trace_all(s, rays, w.count, 0, INSIDE);
    end_flights(w, number);
    for (uint i = w.count; i-- > 0;)
      if (w.state[i] != WALK_ON) leave_walk(b, w, i);
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
