/* What a path leaves in planes beside Combined's.
 *
 * A path has a column of real numbers in `columns`, at its slot: one for each plane of the film's groups, and where
 * light is told apart by the closures of its first bounce, what these have to say of it (Shares). Programs for films
 * without such groups have none of it. */
#ifndef ISOPHOTE_PASSES_H
#define ISOPHOTE_PASSES_H
#include "mattes.h"
#include "stages.h"
#include "vectors.h"

#define GROUP_BIT(name) (1u << GROUP_##name)
#define GROUPS_COLOR (GROUP_BIT(diffuse_color) | GROUP_BIT(glossy_color) | GROUP_BIT(transmission_color))
#define GROUPS_SPLIT                                                                                            \
  (GROUP_BIT(diffuse_direct) | GROUP_BIT(diffuse_indirect) | GROUP_BIT(glossy_direct) | GROUP_BIT(glossy_indirect) | \
   GROUP_BIT(transmission_direct) | GROUP_BIT(transmission_indirect))
#define GROUPS_LIGHT                                                                                        \
  (GROUPS_SPLIT | GROUP_BIT(emission) | GROUP_BIT(environment) | GROUP_BIT(denoising_albedo) | GROUPS_LIGHT_GROUPS)
/* Of the first surface that the path meets, and of those that it sees through transparent ones. */
#define GROUPS_FIRST                                                                                     \
  (GROUP_BIT(depth) | GROUP_BIT(position) | GROUP_BIT(object_index) | GROUP_BIT(material_index) |        \
   GROUP_BIT(normal) | GROUP_BIT(albedo) | GROUP_BIT(uv) | GROUP_BIT(vector))
#define GROUPS_SEEN (GROUPS_FIRST | GROUPS_COLOR | GROUP_BIT(mist) | GROUPS_AOVS | GROUPS_MATTES)
/* Of the first surface along the path that is not sharp. */
#define GROUPS_DENOISING (GROUP_BIT(denoising_normal) | GROUP_BIT(denoising_albedo) | GROUP_BIT(denoising_depth))
#define GROUPS_SURFACE (GROUPS_SEEN | GROUPS_DENOISING)
#define GROUPS_LOOK (GROUP_BIT(normal) | GROUP_BIT(albedo) | GROUPS_COLOR) /* ask closures */

FN int has_any(uint groups, uint wanted) { return (groups & wanted) != 0u; }

FN int plane_takes(uint groups, uint plane, uint sample) {
  return (sample == 0u) | (plane >= plane_of(groups, GROUPS_OF_SAMPLE_0));
}

/* From here on planes have parts of Combined, and lack what it lacks. */
FN uint first_light_plane(uint groups) { return plane_of(groups, GROUP_diffuse_direct); }

FN void add_number(GLOBAL real *columns, uint stride, uint slot, uint groups, uint group, real value) {
  if (has_group(groups, group)) columns[(plane_of(groups, group) - PLANES_COMBINED) * stride + slot] += value;
}

FN void set_number(GLOBAL real *columns, uint stride, uint slot, uint groups, uint group, real value) {
  if (has_group(groups, group)) columns[(plane_of(groups, group) - PLANES_COMBINED) * stride + slot] = value;
}

FN void add_to_plane(GLOBAL real *columns, uint stride, uint slot, uint groups, uint group, real3 value) {
  if (!has_group(groups, group)) return;
  uint at = (plane_of(groups, group) - PLANES_COMBINED) * stride + slot;
  columns[at] += value.x;
  columns[at + stride] += value.y;
  columns[at + 2u * stride] += value.z;
}

/* ------------------------------------------------------------------- light */

/* Columns that a path has. */
FN uint first_guide(uint groups) {
  return planes_end(groups) - PLANES_COMBINED + (has_any(groups, GROUPS_SPLIT) ? SHARE_COLUMNS : 0u);
}
FN uint first_matte(uint groups) {
  return first_guide(groups) + (has_any(groups, GROUPS_DENOISING) ? GUIDE_COLUMNS : 0u);
}
FN uint pass_columns(uint groups) { return first_matte(groups) + matte_numbers(groups, MATTE_RECORDS); }

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
/* Of a path that a volume scatters first: marked by a share that there is not. */
FN Shares shares_of_volume(void) {
  Shares s = no_shares();
  s.diffuse.x = REAL(-1.0);
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

/* Of a path that has met nothing but sharp closures: how they tint what guides a denoiser (show_guides), and whether it
 * is such a path. */
FN real3 load_guide(GLOBAL const real *columns, uint stride, uint slot, uint groups) {
  uint at = first_guide(groups) * stride + slot;
  return make_real3(columns[at], columns[at + stride], columns[at + 2u * stride]);
}
FN int is_guiding(GLOBAL const real *columns, uint stride, uint slot, uint groups) {
  return columns[(first_guide(groups) + 3u) * stride + slot] != REAL(0.0);
}

/* Light groups: of what a path runs into, and of the light drawn at its vertex, in the column behind all others. */
FN uint object_light_group(Scene s, Hit h) {
  World w = s.world[0];
  if (w.sphere_groups == NONE) return 0u;
  return s.light_groups[h.instance == SPHERE_INSTANCE ? w.sphere_groups + h.primitive : h.instance];
}
FN uint drawn_light_group(Scene s, LightWalk walk) { return LIGHT_GROUP(s.lights[walk.at & ~CLUSTER_LIGHT].flags); }
FN uint drawn_group_column(Params params) { return pass_columns(film_groups(params)) + uint_of(params.named_planes); }

/* The set of the object at a path's last vertex, where lights are linked: in the column behind that. */
FN uint link_column(Params params) {
  return drawn_group_column(params) + (has_any(film_groups(params), GROUPS_LIGHT_GROUPS) ? 1u : 0u);
}
FN uint last_set(Scene s, Params params, GLOBAL const real *columns, uint stride, uint slot) {
  if (!(SCENE_FEATURES & s.world[0].features & FEATURE_LINKING)) return NONE;
  return uint_of(columns[link_column(params) * stride + slot]);
}

/* Where light comes from: a group, of what the camera sees itself, or one of these; and above eight bits its light
 * group, which of drawn light is in the path's column. */
#define FROM_PATH 32u
#define FROM_LIGHT 33u
FN uint seen_from(Path p, uint group, uint light_group) { return (path_bounce(p) == 0 ? group : FROM_PATH) | light_group << 8; }

FN void add_light_group(GLOBAL real *columns, uint stride, uint slot, Params params, real3 light, uint group) {
  if (group == 0u) return;
  uint first = pass_columns(film_groups(params)) + uint_of(params.light_plane) + 3u * (group - 1u);
  columns[first * stride + slot] += light.x;
  columns[(first + 1u) * stride + slot] += light.y;
  columns[(first + 2u) * stride + slot] += light.z;
}

FN void add_light_passes(GLOBAL real *columns, uint stride, uint slot, Params params, Brought b, uint where) {
  uint groups = film_groups(params), from = where & 255u;
  if (has_any(groups, GROUPS_LIGHT_GROUPS)) {
    uint drawn = from == FROM_LIGHT ? uint_of(columns[drawn_group_column(params) * stride + slot]) : where >> 8;
    add_light_group(columns, stride, slot, params, b.light, drawn);
  }
  if (has_group(groups, GROUP_denoising_albedo) && from != FROM_LIGHT && is_guiding(columns, stride, slot, groups))
    add_to_plane(columns, stride, slot, groups, GROUP_denoising_albedo, load_guide(columns, stride, slot, groups) * b.light);
  if (from < FROM_PATH) {
    add_to_plane(columns, stride, slot, groups, from, b.light);
    return;
  }
  if (!has_any(groups, GROUPS_SPLIT)) return;
  uint which = ((from == FROM_LIGHT) & !b.indirect) ? SHARES_OF_LIGHT : SHARES_OF_PATH;
  Shares s = load_shares(columns, stride, slot, groups, which);
  if ((SCENE_FEATURES & FEATURE_VOLUME) && s.diffuse.x < REAL(0.0)) { /* no plane of its own: with what volumes emit */
    add_to_plane(columns, stride, slot, groups, GROUP_emission, b.light);
    return;
  }
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
      int diffuse = is_diffuse(i.op) | (i.op == OP_SUBSURFACE);
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
FN void clear_columns(GLOBAL real *columns, uint stride, uint slot, Params params) {
  uint groups = film_groups(params);
  if (has_any(groups, GROUPS_AOVS | GROUPS_LIGHT_GROUPS))
    for (int k = 0; k < params.named_planes; k++) columns[(pass_columns(groups) + uint_of(k)) * stride + slot] = REAL(0.0);
  for (uint k = 0u; k < planes_end(groups) - PLANES_COMBINED; k++) columns[k * stride + slot] = REAL(0.0);
  set_number(columns, stride, slot, groups, GROUP_depth, DEPTH_NOTHING);
  if (has_any(groups, GROUPS_DENOISING))
    for (uint k = 0u; k < GUIDE_COLUMNS; k++) columns[(first_guide(groups) + k) * stride + slot] = REAL(1.0);
  if (has_any(groups, GROUPS_MATTES)) clear_mattes(columns + first_matte(groups) * stride + slot, stride, matte_kinds(groups));
}

/* How clear a place is in the mist of Blender's world (kernel/film/data_passes.h). */
FN real clear_of_mist(Scene s, real3 p) {
  World w = s.world[0];
  real mist = clamp01((camera_distance(s.camera[0], p) - to_real(w.mist_start)) * to_real(w.mist_scale));
  if (w.mist_falloff == 2.0f) mist = mist * mist;
  if (w.mist_falloff == 0.5f) mist = sqrt(mist);
  return REAL(1.0) - mist;
}

FN real object_index(Scene s, Hit h) {
  World w = s.world[0];
  if (w.sphere_indices == NONE) return REAL(0.0);
  return to_real(s.pass_indices[h.instance == SPHERE_INSTANCE ? w.sphere_indices + h.primitive : h.instance]);
}
FN real material_index(Scene s, Surface at) {
  uint first = s.world[0].material_indices;
  return first == NONE ? REAL(0.0) : to_real(s.pass_indices[first + at.material]);
}

/* Coordinates of the UV map and 1, or nothing where the mesh has none. */
FN real3 uv_of_surface(Scene s, Surface at, Path p, Hit h) {
#if SCENE_FEATURES & FEATURE_VALUES
  if (s.world[0].uv == NONE || h.instance == SPHERE_INSTANCE) return zero3();
  if (s.mesh_attributes[s.instance_meshes[h.instance] * s.world[0].attributes + s.world[0].uv].domain == DOMAIN_NONE)
    return zero3();
  Attribute uv = read_attribute(s, s.world[0].uv, make_point(at, path_ray(p), h, 0u, 0u));
  return make_real3(uv.x, uv.y, REAL(1.0));
#else
  return zero3();
#endif
}

/* The Vector pass of a path, and that it has one. */
FN void add_vector(GLOBAL real *columns, uint stride, uint groups, Scene s, Surface at, Path p, Hit h) {
#if VECTORS_USED
  if (!has_group(groups, GROUP_vector) || !s.world[0].vectors) return;
  real4 v = motion_vector(s, at.p, h);
  uint place = (plane_of(groups, GROUP_vector) - PLANES_COMBINED) * stride + p.slot;
  columns[place] = v.x;
  columns[place + stride] = v.y;
  columns[place + 2u * stride] = v.z;
  columns[place + 3u * stride] = v.w;
  columns[place + 4u * stride] = REAL(1.0);
#endif
}

/* AOV outputs, in columns behind all others. */
FN void show_aovs(GLOBAL real *columns, uint stride, uint groups, Scene s, uint material, uint slot, const real *r) {
  uint count = s.world[0].aovs;
  for (uint k = 0u; k < count; k++) {
    AovOutput a = s.aovs[material * count + k];
    if (!(a.flags & AOV_THERE)) continue;
    real3 value = weight_of(a.value, (a.flags & AOV_VARIES) != 0u, r);
    uint at = (pass_columns(groups) + a.plane) * stride + slot;
    columns[at] = value.x;
    if (!a.color) continue;
    columns[at + stride] = value.y;
    columns[at + 2u * stride] = value.z;
    columns[at + 3u * stride] = REAL(1.0);
  }
}

/* A surface that the path meets before its first bounce. */
FN void show_seen(GLOBAL real *columns, uint stride, uint groups, Scene s, Material m, Surface at, Path p, Hit h, const real *r) {
  Look a = look_at_surface(s, m, at, p, r, path_vertex(p) == 0 ? groups : groups & GROUPS_COLOR);
  if (path_vertex(p) == 0) {
    set_number(columns, stride, p.slot, groups, GROUP_depth, camera_depth(s.camera[0], at.p));
    add_to_plane(columns, stride, p.slot, groups, GROUP_position, at.p + load3(s.world[0].origin));
    add_number(columns, stride, p.slot, groups, GROUP_object_index, object_index(s, h));
    add_number(columns, stride, p.slot, groups, GROUP_material_index, material_index(s, at));
    int bumps = (SCENE_FEATURES & FEATURE_BUMP) && (m.flags & MATERIAL_BUMPS);
    int mean = bumps && dot3(a.normals, a.normals) > REAL(0.0);
    add_to_plane(columns, stride, p.slot, groups, GROUP_normal, mean ? normalize3(a.normals) : at.ns);
    add_to_plane(columns, stride, p.slot, groups, GROUP_albedo, a.albedo);
    add_vector(columns, stride, groups, s, at, p, h);
    if (has_any(groups, GROUPS_AOVS)) show_aovs(columns, stride, groups, s, at.material, p.slot, r);
    if (has_group(groups, GROUP_uv)) add_to_plane(columns, stride, p.slot, groups, GROUP_uv, uv_of_surface(s, at, p, h));
  }
  real3 seen = path_throughput(p);
  add_to_plane(columns, stride, p.slot, groups, GROUP_diffuse_color, seen * a.diffuse);
  add_to_plane(columns, stride, p.slot, groups, GROUP_glossy_color, seen * a.glossy);
  add_to_plane(columns, stride, p.slot, groups, GROUP_transmission_color, seen * a.transmission);
  if (!has_any(groups, GROUP_BIT(mist) | GROUPS_MATTES)) return;
  real3 through = (m.flags & MATERIAL_TRANSPARENT) ? material_transparency(m, r) : zero3();
  if (has_any(groups, GROUPS_MATTES))
    show_matte(columns + first_matte(groups) * stride + p.slot, stride, groups, s, h, at.material,
               average3(seen) * (REAL(1.0) - average3(through)));
  if (has_group(groups, GROUP_mist)) {
    real alpha = average3(seen * saturate3(splat3(REAL(1.0)) - through));
    add_number(columns, stride, p.slot, groups, GROUP_mist, clear_of_mist(s, at.p) * alpha);
  }
}

/* --------------------------------------------------------------- denoising */

#define SHARP_ROUGHNESS REAL(0.075) /* squared: at most that is a mirror's */

/* What guides a denoiser: of the first surface that has at least a quarter of its closures' light from such that are not
 * sharp. Mirrors and glass before it tint its albedo and lengthen its distance; light that is seen so far counts as albedo
 * (kernel/film/denoising_passes.h). */
FN void show_guides(GLOBAL real *columns, uint stride, uint groups, Scene s, Material m, Surface at, Path p, Hit h, const real *r) {
  if (!is_guiding(columns, stride, p.slot, groups)) return;
  uint first = first_guide(groups) * stride + p.slot;
  real3 tint = load_guide(columns, stride, p.slot, groups);
  real3 soft = zero3(), sharp = zero3(), normal = zero3();
  real total = REAL(0.0), softness = REAL(0.0);
  Choice choice = make_choice(REAL(0.0));
  for (uint k = 0u; k < m.count; k++) {
    Instruction i = s.instructions[m.first + k];
    Closure c = closure_of(i, r);
    Frame frame = frame_of(i, at, r);
    real3 wo = to_local(frame, make_real3(-p.dx, -p.dy, -p.dz));
    if (is_closure(i.op)) {
      real3 weight = closure_weight(c, choice);
      real3 albedo = albedo_closure(c, at.backfacing, s.albedo_tables, wo);
      real share = closure_share(weight, albedo);
      int is_soft = roughness_product(c) > SHARP_ROUGHNESS;
      normal = normal + frame.z * share;
      total = total + share;
      softness = softness + (is_soft ? share : REAL(0.0));
      soft = soft + select3(is_soft, albedo * weight, zero3());
      sharp = sharp + select3(is_soft, zero3(), albedo * weight);
    } else {
      choice.layer = layer_closure(c, at.backfacing, s.albedo_tables, wo, choice.layer);
    }
  }
  add_number(columns, stride, p.slot, groups, GROUP_denoising_depth, average3(tint) * h.t);
  if (total == REAL(0.0) || softness * REAL(4.0) > total) {
    normal = normal * (total > REAL(0.0) ? REAL(1.0) / total : REAL(0.0));
    add_to_plane(columns, stride, p.slot, groups, GROUP_denoising_normal, turned_to_camera(s.camera[0], normal));
    add_to_plane(columns, stride, p.slot, groups, GROUP_denoising_albedo, tint * soft);
    columns[first + 3u * stride] = REAL(0.0);
  } else {
    columns[first] = tint.x * sharp.x;
    columns[first + stride] = tint.y * sharp.y;
    columns[first + 2u * stride] = tint.z * sharp.z;
  }
}

/* Whether nothing of a surface is left to be seen. */
FN int is_held_out(Scene s, Material m, const real *r) {
  if (!IS_USED(OP_HOLDOUT) || !(m.flags & MATERIAL_HOLDS_OUT)) return 0;
  real3 share = held_share(s, m, r);
  return (share.x == REAL(1.0)) & (share.y == REAL(1.0)) & (share.z == REAL(1.0));
}

FN void show_surface(GLOBAL real *columns, uint stride, uint groups, Scene s, Material m, Surface at, Path p, Hit h, const real *r) {
  if (is_inside(p)) return; /* has shown where it went below */
  if ((p.status & PATH_FROM_CAMERA) && is_held_out(s, m, r)) return;
  if (has_any(groups, GROUPS_SEEN) && path_bounce(p) == 0) show_seen(columns, stride, groups, s, m, at, p, h, r);
  if (has_any(groups, GROUPS_DENOISING)) show_guides(columns, stride, groups, s, m, at, p, h, r);
}

#endif
