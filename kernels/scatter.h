/* One step of a material's program at a time, so that OpenCL can loop over the program for its path
 * and OpenMP over its paths for each instruction, with the same arithmetic in the same order. */
#ifndef ISOPHOTE_SCATTER_H
#define ISOPHOTE_SCATTER_H
#include "bsdf/bsdf.h"
#include "values/program.h"

/* Operations that are closures; the others change the layer weight. */
FN int is_closure(int op) {
  switch (op) {
#define X(number, name, class_) case number:
    CLOSURES(X)
#undef X
    return 1;
    default: return 0;
  }
}

/* Whether it is a diffuse closure. */
FN int is_diffuse(int op) {
  switch (op) {
#define X(number, name, class_) case number: return ((class_) & LABEL_DIFFUSE) != 0;
    CLOSURES(X)
#undef X
    default: return 0;
  }
}

/* What a path makes of a material that it meets. Who has been scattered diffusely before cannot tell where light comes
 * out from where it goes in: subsurface scattering is diffuse to him, as in Cycles 4.5. */
FN int meets_diffuse(uint kind, uint material_flags) {
  return (SCENE_FEATURES & FEATURE_SUBSURFACE) && (kind & RAY_AFTER_DIFFUSE) && (material_flags & MATERIAL_SUBSURFACE);
}
FN Instruction met_instruction(Instruction i, int diffuse) {
  if ((SCENE_FEATURES & FEATURE_SUBSURFACE) && diffuse && i.op == OP_SUBSURFACE) i.op = OP_DIFFUSE;
  return i;
}
FN Material met_material(Material m, int diffuse) {
  if ((SCENE_FEATURES & FEATURE_SUBSURFACE) && diffuse) m.flags &= ~MATERIAL_DELTA_ONLY;
  return m;
}
/* To light that comes out from below any material is white and diffuse, with the normal of its subsurface scattering. */
FN Material exit_material(Scene s, Material m) {
  m.first += m.count;
  m.count = 1u;
  int bumps = (s.instructions[m.first].flags & INSTRUCTION_BUMPS) != 0u;
  m.flags = bumps ? MATERIAL_BUMPS : 0u;
  m.steps = bumps ? m.steps : 0u;
  return m;
}

/* An instruction's closure at a point whose values lie in registers r. */
FN Closure closure_of(Instruction i, const real *r) {
  if ((SCENE_FEATURES & FEATURE_VALUES) && (i.flags & INSTRUCTION_VARIES)) return bind_closure(i, r);
  return make_closure(i);
}

FN real3 load_registers3(uint first, const real *r) {
  return make_real3(r[first * REGISTER_STRIDE], r[(first + 1u) * REGISTER_STRIDE], r[(first + 2u) * REGISTER_STRIDE]);
}
FN int has_own_frame(Instruction i) { return (SCENE_FEATURES & FEATURE_BUMP) && (i.flags & INSTRUCTION_BUMPS); }
/* The frame of a closure that has its own. */
FN Frame own_frame(Instruction i, const real *r) {
  real3 n = load_registers3(INSTRUCTION_NORMAL(i.flags), r);
  if (!INSTRUCTION_TANGENT(i.flags)) return make_frame(n);
  return make_frame_along(n, load_registers3(INSTRUCTION_TANGENT(i.flags) - 1u, r));
}
FN Frame frame_of(Instruction i, Surface at, const real *r) {
  return has_own_frame(i) ? own_frame(i, r) : make_frame(at.ns);
}

/* Choosing one closure in proportion to its share of the reflected light, in one pass over the
 * program: the running choice is replaced with the probability of the newcomer's share, and the
 * random number is stretched again after each decision (weighted reservoir sampling, Chao 1982). */
typedef struct {
  real3 layer; /* what the layers passed so far let through */
  real total;  /* sum of shares */
  real u;
  int chosen; /* index in the program, -1: none */
  real share; /* of the chosen one */
} Choice;

FN Choice make_choice(real u) {
  Choice c;
  c.layer = splat3(REAL(1.0));
  c.total = REAL(0.0);
  c.u = u;
  c.chosen = -1;
  c.share = REAL(0.0);
  return c;
}

FN real3 closure_weight(Closure one, Choice c) { return one.weight * c.layer; }

FN real closure_share(real3 weight, real3 albedo) {
  real3 w = weight * albedo;
  return max_real(w.x + w.y + w.z, REAL(0.0));
}

FN Choice consider(Choice c, int index, real share) {
  real total = c.total + share;
  real p = share > REAL(0.0) ? share / total : REAL(0.0);
  int take = c.u < p;
  real stretched = take ? c.u / p : (c.u - p) / (REAL(1.0) - p);
  c.u = share > REAL(0.0) ? clamp01(stretched) : c.u;
  c.u = min_real(c.u, REAL(0.99999994));
  c.chosen = take ? index : c.chosen;
  c.share = take ? share : c.share;
  c.total = total;
  return c;
}

/* The kind of ray that a closure sends towards a light, as RAY_ bits; `behind`: the light is on the other side. */
FN uint kind_towards(int op, int behind) {
  if (behind) return RAY_TRANSMISSION | (is_diffuse(op) ? RAY_SOFT : 0u);
  return is_diffuse(op) ? RAY_DIFFUSE : RAY_GLOSSY;
}

/* Adds one closure to the value of the whole BSDF; share is its part of the choice's total. */
FN BsdfValue add_closure(BsdfValue sum, BsdfValue one, real3 weight, real share, real total) {
  sum.f = sum.f + one.f * weight;
  sum.pdf = sum.pdf + one.pdf * (share / total);
  return sum;
}

/* No light passes where the geometric and the shading normal disagree about the side it comes from. */
FN BsdfValue one_sided(Surface s, real3 wi, BsdfValue v) {
  int agree = (dot3(s.ng, wi) > REAL(0.0)) == (dot3(s.ns, wi) > REAL(0.0));
  return make_value(select3(agree, v.f, zero3()), agree ? v.pdf : REAL(0.0));
}
/* The same for a closure, whose own normal may be another: in_frame is wi in its frame. */
FN BsdfValue one_sided_closure(real3 ng, real3 wi, real3 in_frame, BsdfValue v) {
  int agree = (dot3(ng, wi) > REAL(0.0)) == (in_frame.z > REAL(0.0));
  return make_value(select3(agree, v.f, zero3()), agree ? v.pdf : REAL(0.0));
}
/* Softens the edge that the surface's normal ns casts on a diffuse closure with another normal n, by GGX' masking of a
 * roughness that follows from the angle between them: Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing
 * Function to Solve the Bump Terminator Problem", equation 3. None passes ns where n has the light on the other side. */
FN BsdfValue soften_bump(real3 ns, real3 n, real3 wi, BsdfValue v) {
  real cos_i = dot3(ns, wi), cos_n = dot3(ns, n);
  int crosses = cos_i * cos_n * dot3(n, wi) < REAL(0.0);
  real i2 = max_real(cos_i * cos_i, REAL(1e-12)), n2 = max_real(cos_n * cos_n, REAL(1e-12));
  real alpha2 = clamp01(REAL(0.125) * (REAL(1.0) / n2 - REAL(1.0)));
  real masked = REAL(2.0) / (REAL(1.0) + sqrt(REAL(1.0) + alpha2 * max_real(REAL(1.0) / i2 - REAL(1.0), REAL(0.0))));
  v.f = v.f * (crosses ? REAL(0.0) : masked);
  return v;
}
FN BsdfSample one_sided_sample(Surface s, real3 wi, BsdfSample b) {
  int agree = (dot3(s.ng, wi) > REAL(0.0)) == (b.wi.z > REAL(0.0));
  b.valid = b.valid & (agree | ((b.label & LABEL_TRANSPARENT) != 0));
  return b;
}

#endif
