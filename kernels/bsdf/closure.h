/* What every closure takes and returns.
 *
 * wo (to the viewer) and wi (to the light) are unit, in the frame of the shading normal, wo.z > 0;
 * transmission has wi.z < 0. `backfacing`: the ray met the geometric back side, so an index of
 * refraction is inverted. Parameters are those of isophote/materials.py. */
#ifndef ISOPHOTE_BSDF_CLOSURE_H
#define ISOPHOTE_BSDF_CLOSURE_H
#include "../scene_records.h"

#define LABEL_REFLECT 1
#define LABEL_TRANSMIT 2
#define LABEL_DIFFUSE 4
#define LABEL_GLOSSY 8
#define LABEL_SINGULAR 16
#define LABEL_TRANSPARENT 32
#define LABEL_SUBSURFACE 64

/* A closure at the point that is shaded: an Instruction with the values of its parameters. */
typedef struct {
  int op;
  real3 weight;
  real params[INSTRUCTION_PARAMS];
} Closure;

/* Of an instruction whose parameters are constants. */
FN Closure make_closure(Instruction i) {
  Closure c;
  c.op = i.op;
  c.weight = load3(i.weight);
  for (int k = 0; k < INSTRUCTION_PARAMS; k++) c.params[k] = to_real(i.params[k]);
  return c;
}

/* Of one that varies: what registers hold. */
FN Closure bind_closure(Instruction i, const real *r) {
  Closure c;
  c.op = i.op;
  c.weight = make_real3(r[uint_of(i.weight.x) * REGISTER_STRIDE], r[uint_of(i.weight.y) * REGISTER_STRIDE],
                        r[uint_of(i.weight.z) * REGISTER_STRIDE]);
  for (int k = 0; k < INSTRUCTION_PARAMS; k++) c.params[k] = r[uint_of(i.params[k]) * REGISTER_STRIDE];
  return c;
}

typedef struct {
  real3 f;  /* BSDF times |cos(wi)| and the closure's tint, without Closure.weight */
  real pdf; /* with which sample_NAME draws wi, per solid angle */
} BsdfValue;

/* Where delta is set, f is the whole factor of the path: BSDF cos / pdf, divided also by the chance
 * of having chosen this lobe. Elsewhere f is unset and the caller evaluates all closures at wi. */
typedef struct {
  real3 wi;
  real3 f;
  int delta;
  int label;
  int valid; /* 0: absorbed, as microfacets that send light into the surface do */
} BsdfSample;

FN BsdfValue make_value(real3 f, real pdf) {
  BsdfValue v;
  v.f = f;
  v.pdf = pdf;
  return v;
}

FN BsdfSample make_sample(real3 wi, real3 f, int delta, int label, int valid) {
  BsdfSample s;
  s.wi = wi;
  s.f = f;
  s.delta = delta;
  s.label = label;
  s.valid = valid;
  return s;
}

FN real param(Closure c, int k) { return c.params[k]; }
FN real3 param3(Closure c, int k) { return make_real3(c.params[k], c.params[k + 1], c.params[k + 2]); }
FN real average3(real3 v) { return (v.x + v.y + v.z) * REAL(0.33333333333333333); }
FN real3 saturate3(real3 v) { return make_real3(clamp01(v.x), clamp01(v.y), clamp01(v.z)); }

#endif
