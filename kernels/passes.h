/* What a path leaves in planes beside Combined's.
 *
 * A path has a column of real numbers in `columns`, at its slot: one for each plane of the film's groups, and where
 * light is told apart by the closures of its first bounce, what these have to say of it (Shares). Programs for films
 * without such groups have none of it. */
#ifndef ISOPHOTE_PASSES_H
#define ISOPHOTE_PASSES_H
#include "stages.h"

#define GROUP_BIT(name) (1u << GROUP_##name)
#define GROUPS_COLOR (GROUP_BIT(diffuse_color) | GROUP_BIT(glossy_color) | GROUP_BIT(transmission_color))
#define GROUPS_SPLIT                                                                                            \
  (GROUP_BIT(diffuse_direct) | GROUP_BIT(diffuse_indirect) | GROUP_BIT(glossy_direct) | GROUP_BIT(glossy_indirect) | \
   GROUP_BIT(transmission_direct) | GROUP_BIT(transmission_indirect))
#define GROUPS_LIGHT (GROUPS_SPLIT | GROUP_BIT(emission) | GROUP_BIT(environment))
/* Of the first surface that the path meets, and of those that it sees through transparent ones. */
#define GROUPS_FIRST (GROUP_BIT(depth) | GROUP_BIT(position) | GROUP_BIT(normal) | GROUP_BIT(albedo))
#define GROUPS_SURFACE (GROUPS_FIRST | GROUPS_COLOR)
#define GROUPS_LOOK (GROUP_BIT(normal) | GROUP_BIT(albedo) | GROUPS_COLOR) /* ask closures */

FN int has_any(uint groups, uint wanted) { return (groups & wanted) != 0u; }

FN int plane_takes(uint groups, uint plane, uint sample) {
  return (sample == 0u) | (plane >= plane_of(groups, GROUPS_OF_SAMPLE_0));
}

/* From here on planes have parts of Combined, and lack what it lacks. */
FN uint first_light_plane(uint groups) { return plane_of(groups, GROUP_diffuse_direct); }

FN void add_to_plane(GLOBAL real *columns, uint stride, uint slot, uint groups, uint group, real3 value) {
  if (!has_group(groups, group)) return;
  uint at = (plane_of(groups, group) - PLANES_COMBINED) * stride + slot;
  columns[at] += value.x;
  columns[at + stride] += value.y;
  columns[at + 2u * stride] += value.z;
}

/* ------------------------------------------------------------------- light */

/* Columns that a path has. */
#define SHARE_COLUMNS 12u
FN uint pass_columns(uint groups) {
  return planes_end(groups) - PLANES_COMBINED + (has_any(groups, GROUPS_SPLIT) ? SHARE_COLUMNS : 0u);
}

/* What parts of light came by the diffuse and by the glossy closures of the path's first bounce; those that transmit
 * have the rest. Cycles' light passes are told apart so (kernel/film/light_passes.h). */
typedef struct {
  real3 diffuse, glossy;
} Shares;

/* Of light that comes to the first vertex along the path, and of that from the light drawn there. */
#define SHARES_OF_PATH 0u
#define SHARES_OF_LIGHT 1u

FN uint first_share(uint groups, uint which) { return planes_end(groups) - PLANES_COMBINED + 6u * which; }

FN void store_shares(GLOBAL real *columns, uint stride, uint slot, uint groups, uint which, Shares s) {
  uint at = first_share(groups, which) * stride + slot;
  columns[at] = s.diffuse.x;
  columns[at + stride] = s.diffuse.y;
  columns[at + 2u * stride] = s.diffuse.z;
  columns[at + 3u * stride] = s.glossy.x;
  columns[at + 4u * stride] = s.glossy.y;
  columns[at + 5u * stride] = s.glossy.z;
}

FN Shares load_shares(GLOBAL const real *columns, uint stride, uint slot, uint groups, uint which) {
  uint at = first_share(groups, which) * stride + slot;
  Shares s;
  s.diffuse = make_real3(columns[at], columns[at + stride], columns[at + 2u * stride]);
  s.glossy = make_real3(columns[at + 3u * stride], columns[at + 4u * stride], columns[at + 5u * stride]);
  return s;
}

/* Parts of the whole BSDF, in the order of the program. */
FN Shares no_shares(void) {
  Shares s;
  s.diffuse = zero3();
  s.glossy = zero3();
  return s;
}
/* What a closure has added to the BSDF; cosine: between its normal and the direction. */
FN Shares add_part(Shares parts, real3 before, real3 after, int diffuse, real cosine) {
  real3 added = after - before;
  parts.diffuse = parts.diffuse + select3(diffuse, added, zero3());
  parts.glossy = parts.glossy + select3(!diffuse & (cosine > REAL(0.0)), added, zero3());
  return parts;
}

FN real share_of(real part, real whole) { return whole > REAL(0.0) ? clamp01(part / whole) : REAL(0.0); }
FN real3 shares_of(real3 part, real3 whole) {
  return make_real3(share_of(part.x, whole.x), share_of(part.y, whole.y), share_of(part.z, whole.z));
}
FN Shares make_shares(Shares parts, real3 whole) {
  Shares s;
  s.diffuse = shares_of(parts.diffuse, whole);
  s.glossy = shares_of(parts.glossy, whole);
  return s;
}
/* Of a path that goes on; a mirror and smooth glass have all of it. */
FN Shares path_shares(Shares parts, real3 whole, BsdfSample sample) {
  Shares s = make_shares(parts, whole), sharp = no_shares();
  sharp.glossy = splat3((sample.label & LABEL_REFLECT) ? REAL(1.0) : REAL(0.0));
  s.diffuse = select3(sample.delta, sharp.diffuse, s.diffuse);
  s.glossy = select3(sample.delta, sharp.glossy, s.glossy);
  return s;
}

/* Where light comes from: a group, of what the camera sees itself, or one of these. */
#define FROM_PATH 32u
#define FROM_LIGHT 33u
FN uint seen_from(Path p, uint group) { return path_bounce(p) == 0 ? group : FROM_PATH; }

FN void add_light_passes(GLOBAL real *columns, uint stride, uint slot, uint groups, Brought b, uint from) {
  if (from < FROM_PATH) {
    add_to_plane(columns, stride, slot, groups, from, b.light);
    return;
  }
  if (!has_any(groups, GROUPS_SPLIT)) return;
  uint which = ((from == FROM_LIGHT) & !b.indirect) ? SHARES_OF_LIGHT : SHARES_OF_PATH;
  Shares s = load_shares(columns, stride, slot, groups, which);
  real3 diffuse = b.light * s.diffuse, glossy = b.light * s.glossy;
  real3 transmitted = b.light - diffuse - glossy;
  add_to_plane(columns, stride, slot, groups, b.indirect ? GROUP_diffuse_indirect : GROUP_diffuse_direct, diffuse);
  add_to_plane(columns, stride, slot, groups, b.indirect ? GROUP_glossy_indirect : GROUP_glossy_direct, glossy);
  add_to_plane(columns, stride, slot, groups, b.indirect ? GROUP_transmission_indirect : GROUP_transmission_direct,
               transmitted);
}

/* ---------------------------------------------------------------- surfaces */

/* What the camera sees of a surface's closures: directional albedos towards it, all together and by kind, and the mean
 * of their normals. Transparency is in `albedo` alone. */
typedef struct {
  real3 albedo, diffuse, glossy, transmission, normals;
} Look;

FN real3 positive3(real3 v) {
  return make_real3(max_real(v.x, REAL(0.0)), max_real(v.y, REAL(0.0)), max_real(v.z, REAL(0.0)));
}

FN Look look_at_surface(Scene s, Material m, Surface at, Path p, const real *r, uint groups) {
  Look a;
  a.albedo = zero3();
  a.diffuse = zero3();
  a.glossy = zero3();
  a.transmission = zero3();
  a.normals = zero3();
  if (!has_any(groups, GROUPS_LOOK)) return a;
  Choice choice = make_choice(REAL(0.0));
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = s.instructions[m.first + k];
    Closure c = closure_of(i, r);
    Frame frame = frame_of(i, at, r);
    real3 wo = to_local(frame, make_real3(-p.dx, -p.dy, -p.dz));
    real3 weight = closure_weight(c, choice);
    if (is_closure(i.op)) a.normals = a.normals + frame.z * average3(abs3(weight));
    real3 albedo = albedo_closure(c, at.backfacing, s.albedo_tables, wo) * weight;
    a.albedo = a.albedo + albedo;
    if (has_any(groups, GROUPS_COLOR) && i.op != OP_TRANSPARENT) {
      int diffuse = is_diffuse(i.op);
      real3 through = transmitted_closure(c, at.backfacing, s.albedo_tables, wo) * weight;
      a.diffuse = a.diffuse + select3(diffuse, albedo, zero3());
      a.glossy = a.glossy + select3(diffuse, zero3(), positive3(albedo - through));
      a.transmission = a.transmission + through;
    }
    choice.layer = layer_closure(c, at.backfacing, s.albedo_tables, wo, choice.layer);
  }
  return a;
}

/* Values of a path that has met nothing yet. */
FN void clear_columns(GLOBAL real *columns, uint stride, uint slot, uint groups) {
  for (uint k = 0u; k < planes_end(groups) - PLANES_COMBINED; k++) columns[k * stride + slot] = REAL(0.0);
  if (has_group(groups, GROUP_depth)) columns[(plane_of(groups, GROUP_depth) - PLANES_COMBINED) * stride + slot] = DEPTH_NOTHING;
}

/* A surface that the path meets before its first bounce. */
FN void show_surface(GLOBAL real *columns, uint stride, uint groups, Scene s, Material m, Surface at, Path p, const real *r) {
  if (path_bounce(p) > 0) return;
  Look a = look_at_surface(s, m, at, p, r, groups);
  if (path_vertex(p) == 0) {
    if (has_group(groups, GROUP_depth))
      columns[(plane_of(groups, GROUP_depth) - PLANES_COMBINED) * stride + p.slot] = camera_depth(s.camera[0], at.p);
    add_to_plane(columns, stride, p.slot, groups, GROUP_position, at.p + load3(s.world[0].origin));
    int bumps = (SCENE_FEATURES & FEATURE_BUMP) && (m.flags & MATERIAL_BUMPS);
    int mean = bumps && dot3(a.normals, a.normals) > REAL(0.0);
    add_to_plane(columns, stride, p.slot, groups, GROUP_normal, mean ? normalize3(a.normals) : at.ns);
    add_to_plane(columns, stride, p.slot, groups, GROUP_albedo, a.albedo);
  }
  real3 seen = path_throughput(p);
  add_to_plane(columns, stride, p.slot, groups, GROUP_diffuse_color, seen * a.diffuse);
  add_to_plane(columns, stride, p.slot, groups, GROUP_glossy_color, seen * a.glossy);
  add_to_plane(columns, stride, p.slot, groups, GROUP_transmission_color, seen * a.transmission);
}

#endif
