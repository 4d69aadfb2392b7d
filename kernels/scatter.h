/* One step of a material's program at a time, so that OpenCL can loop over the program for its path
 * and OpenMP over its paths for each instruction, with the same arithmetic in the same order. */
#ifndef ISOPHOTE_SCATTER_H
#define ISOPHOTE_SCATTER_H
#include "bsdf/bsdf.h"
#include "surface.h"

#define MAX_CLOSURES 32 /* instructions of one program; validate.py names materials that have more */

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
FN BsdfSample one_sided_sample(Surface s, real3 wi, BsdfSample b) {
  int agree = (dot3(s.ng, wi) > REAL(0.0)) == (b.wi.z > REAL(0.0));
  b.valid = b.valid & (agree | ((b.label & LABEL_TRANSPARENT) != 0));
  return b;
}

#endif
