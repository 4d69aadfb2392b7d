/* The native module: the only file that knows nanobind. numpy in, numpy out; what arrays mean is said
 * in isophote/prepare.py and isophote/openmp.py, which are its only users. */
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "../kernels/params.h"
#include "../kernels/scene_buffers.h"
#include "bvh_build.h"
#include "emission.h"
#include "fingerprint.h"
#include "fold_value.h"
#include "isophote_build.h"
#include "refit.h"
#include "render.h"
#include "sky.h"
#include "split_vertices.h"
#include "totals.h"
#include "triangles.h"

namespace nb = nanobind;
using namespace isophote;

namespace isophote {
#define X(name, precision, level)                                                                       \
  namespace name {                                                                                      \
  bool render(const void *const *, const WideTree *, const void *, int, float *, uint64_t *, uint64_t *,      \
              const std::atomic<int> *);                                                                \
  void trace_rays(const void *const *, const WideTree *, const float *, long, int, int, int, float *, unsigned *); \
  size_t batch_bytes();                                                                                     \
  }
ISOPHOTE_VARIANTS(X)
#undef X
}  // namespace isophote

namespace {

const Variant VARIANTS[] = {
#define X(name, precision, level) {#name, #precision, level, name::render, name::trace_rays, name::batch_bytes},
    ISOPHOTE_VARIANTS(X)
#undef X
};

const Variant &find_variant(const std::string &name) {
  for (const Variant &v : VARIANTS)
    if (name == v.name) return v;
  throw std::invalid_argument("no variant " + name + " in this build");
}

/* Whether this processor runs code for x86-64-v<level>; 0 runs everywhere. */
bool is_supported(int level) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  switch (level) {
    case 4: return __builtin_cpu_supports("x86-64-v4");
    case 3: return __builtin_cpu_supports("x86-64-v3");
    case 2: return __builtin_cpu_supports("x86-64-v2");
  }
#endif
  return level == 0;
}

template <typename T>
nb::object to_array(std::vector<T> &&values, size_t columns = 1) {
  auto *kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<T> *>(p); });
  size_t shape[2] = {kept->size() / columns, columns};
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), columns == 1 ? 1 : 2, shape, owner));
}

/* The bytes of records, without copying them. */
template <typename T>
nb::object to_bytes(std::vector<T> &&records) {
  auto *kept = new std::vector<T>(std::move(records));
  nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<T> *>(p); });
  size_t shape[1] = {kept->size() * sizeof(T)};
  return nb::cast(nb::ndarray<nb::numpy, uint8_t>(reinterpret_cast<uint8_t *>(kept->data()), 1, shape, owner));
}

using Floats = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Uints = nb::ndarray<const uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<const uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

using Indices = nb::ndarray<const uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Ints = nb::ndarray<const int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Doubles = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MutableDoubles = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MutableBytes = nb::ndarray<uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MutableFloats = nb::ndarray<float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

size_t uses_in(const Bytes &uses) {
  if (uses.size() % sizeof(MeshUse)) throw std::invalid_argument("uses of meshes of the wrong size");
  return uses.size() / sizeof(MeshUse);
}

/* Meshes, and the arrays that they are in. */
struct MeshArrays {
  Floats vertices;
  Indices triangles;
  Uints first;
  Bytes uses;

  MeshArrays(Floats vertices_, Indices triangles_, Uints first_, Bytes uses_)
      : vertices(vertices_), triangles(triangles_), first(first_), uses(uses_) {
    if (first.shape(0) != uses_in(uses) + 1 || first.data()[uses_in(uses)] != triangles.shape(0))
      throw std::invalid_argument("Meshes: the first triangles do not fit the uses or the triangles");
  }
  Meshes view() const {
    return {vertices.data(), triangles.data(), first.data(), reinterpret_cast<const MeshUse *>(uses.data()), uses_in(uses)};
  }
  LeafTriangles leaves(const Uints &order, const Bytes &last) const {
    if (order.shape(0) != last.shape(0)) throw std::invalid_argument("order and last must have the same length");
    return {view(), order.data(), last.data(), order.shape(0)};
  }
};

BuildInput build_input(const MeshArrays &meshes, const Uints &members, float margin, float item_cost) {
  std::vector<uint32_t> all(members.data(), members.data() + members.shape(0));
  for (uint32_t m : all)
    if (m >= meshes.view().count) throw std::invalid_argument("members: no such mesh");
  return {meshes.view(), std::move(all), nullptr, nullptr, nullptr, 0, margin, item_cost};
}

nb::tuple make_tree(const MeshArrays &meshes, Uints members, Floats lo, Floats hi, Uints reference, float margin,
                    float item_cost, int max_leaf, int threads) {
  BuildInput input = build_input(meshes, members, margin, item_cost);
  input.others = lo.shape(0);
  if (hi.shape(0) != input.others || reference.shape(0) != input.others)
    throw std::invalid_argument("make_tree: lo, hi and reference must have the same length");
  input.lo = lo.data(), input.hi = hi.data(), input.reference = reference.data();
  if ((input.meshes.triangle_count() + input.others) >> 30)
    throw std::invalid_argument("make_tree: a scene holds less than 2^30 triangles and other things");
  Tree tree;
  {
    nb::gil_scoped_release release;
    tree = build_tree(std::move(input), max_leaf, threads);
  }
  return nb::make_tuple(to_bytes(std::move(tree.nodes)), to_array(std::move(tree.order)), to_array(std::move(tree.last)),
                        tree.root, tree.depth);
}

/* Seconds of the stages of building, as in Tree. */
std::vector<double> time_tree(const MeshArrays &meshes, Uints members, float margin, float item_cost, int max_leaf,
                              int threads) {
  BuildInput input = build_input(meshes, members, margin, item_cost);
  nb::gil_scoped_release release;
  Tree tree = build_tree(std::move(input), max_leaf, threads);
  return {tree.seconds, tree.seconds + 3};
}

nb::dict wide_bytes(const WideTree &tree) {
  nb::dict bytes;
  bytes["wide_nodes"] = tree.nodes.size() * sizeof(WideNode);
  bytes["blocks"] = tree.blocks.size() * sizeof(TriangleBlock);
  return bytes;
}

std::vector<const void *> pointers(const std::vector<Bytes> &buffers) {
  std::vector<const void *> p;
  for (const Bytes &b : buffers) p.push_back(b.data());
  return p;
}

/* `sources`: (nodes, order, last, root) of a BVH2, or (wide tree, number of its part). */
WideTree wide_tree(const MeshArrays &meshes, nb::list sources, Uints tree_of, int threads) {
  std::vector<WideSource> all;
  for (nb::handle each : sources) {
    auto source = nb::cast<nb::tuple>(each);
    if (source.size() == 2) {
      const auto *kept = nb::cast<const WideTree *>(source[0]);
      all.push_back({nullptr, 0, {}, NONE, kept, nb::cast<size_t>(source[1])});
      if (all.back().part >= kept->parts.size()) throw std::invalid_argument("make_wide_tree: no such part");
    } else {
      auto nodes = nb::cast<Bytes>(source[0]); /* the tuple keeps the arrays */
      all.push_back({reinterpret_cast<const Bvh2Node *>(nodes.data()), nodes.size() / sizeof(Bvh2Node),
                     meshes.leaves(nb::cast<Uints>(source[1]), nb::cast<Bytes>(source[2])), nb::cast<uint32_t>(source[3]),
                     nullptr, 0});
    }
  }
  for (size_t i = 0; i < tree_of.size(); i++)
    if (tree_of.data()[i] != NONE && tree_of.data()[i] >= all.size()) throw std::invalid_argument("make_wide_tree: no such tree");
  if (all.empty()) throw std::invalid_argument("make_wide_tree: no tree");
  nb::gil_scoped_release release;
  return make_wide_tree(all, tree_of.data(), tree_of.size(), threads);
}

nb::tuple refit_wide(const MeshArrays &meshes, WideTree &tree, size_t part, Floats lo, Floats hi, Uints reference,
                     float margin, int threads) {
  size_t count = reference.shape(0);
  if (part >= tree.parts.size() || lo.shape(0) != count || hi.shape(0) != count)
    throw std::invalid_argument("refit_wide_tree: no such part, or not a box for each reference");
  Leaves leaves{{meshes.view(), nullptr, nullptr, 0}, reference.data(), lo.data(), hi.data(), count, margin};
  double cost;
  {
    nb::gil_scoped_release release;
    cost = refit_part(tree, part, leaves, threads);
  }
  return nb::make_tuple(tree.parts[part].built_cost, cost);
}

bool render(const std::string &variant, const std::vector<Bytes> &buffers, const WideTree &tree, Bytes params, int threads,
            nb::ndarray<float, nb::ndim<3>, nb::c_contig, nb::device::cpu> sums,
            nb::ndarray<uint64_t, nb::shape<2>, nb::c_contig, nb::device::cpu> rays,
            nb::ndarray<uint64_t, nb::shape<LIMITS>, nb::c_contig, nb::device::cpu> limits,
            nb::ndarray<int32_t, nb::shape<1>, nb::c_contig, nb::device::cpu> cancelled) {
  const Variant &v = find_variant(variant);
  const Params *p = reinterpret_cast<const Params *>(params.data());
  if (params.size() < sizeof(Params) ||
      params.size() != sizeof(Params) + (p->listed ? sizeof(ListedPixel) * size_t(p->width) : 0))
    throw std::invalid_argument("render: params of the wrong size");
  size_t planes = film_planes(*p);
  if (sums.shape(0) < planes || sums.shape(1) != size_t(p->height) || sums.shape(2) != size_t(p->width))
    throw std::invalid_argument("render: sums do not have the shape of the region");
  std::vector<const void *> scene = pointers(buffers);
  float *out = sums.data();
  uint64_t *counts = rays.data(), *ended = limits.data();
  auto *flag = reinterpret_cast<const std::atomic<int> *>(cancelled.data());
  nb::gil_scoped_release release;
  return v.render(scene.data(), &tree, p, threads, out, counts, ended, flag);
}

nb::tuple trace(const std::string &variant, const std::vector<Bytes> &buffers, const WideTree *tree,
                nb::ndarray<const float, nb::shape<-1, 8>, nb::c_contig, nb::device::cpu> rays, bool any, int threads, bool packets) {
  const Variant &v = find_variant(variant);
  std::vector<const void *> scene = pointers(buffers);
  size_t n = rays.shape(0);
  std::vector<float> hits(3 * n);
  std::vector<uint32_t> ids(2 * n);
  {
    nb::gil_scoped_release release;
    v.trace(scene.data(), tree, rays.data(), long(n), any, threads, packets, hits.data(), ids.data());
  }
  return nb::make_tuple(to_array(std::move(hits), 3), to_array(std::move(ids), 2));
}

void bake_vertices_of(Floats from, Uints first, Bytes uses, int threads, MutableFloats to) {
  size_t meshes = uses_in(uses);
  if (first.shape(0) != meshes + 1 || first.data()[meshes] != from.shape(0) || to.shape(0) != from.shape(0))
    throw std::invalid_argument("bake_vertices: arrays do not fit the meshes");
  nb::gil_scoped_release release;
  bake_vertices(from.data(), first.data(), reinterpret_cast<const MeshUse *>(uses.data()), meshes, to.data(), threads);
}

void bake_normals_of(Floats from, Ints first_normal, Uints first, Bytes uses, int threads, MutableFloats to) {
  size_t meshes = uses_in(uses);
  if (first.shape(0) != meshes + 1 || first_normal.shape(0) != meshes || to.shape(0) != from.shape(0))
    throw std::invalid_argument("bake_normals: arrays do not fit the meshes");
  for (size_t m = 0; m < meshes; m++)
    if (first_normal.data()[m] >= 0 && size_t(first_normal.data()[m]) + first.data()[m + 1] - first.data()[m] > from.shape(0))
      throw std::invalid_argument("bake_normals: a mesh has fewer normals than vertices");
  nb::gil_scoped_release release;
  bake_normals(from.data(), first_normal.data(), first.data(), reinterpret_cast<const MeshUse *>(uses.data()), meshes,
               to.data(), threads);
}

void fold(int op, Doubles inputs, unsigned repeat, float number, MutableDoubles outputs) {
  if (inputs.shape(0) > STEP_INPUTS || outputs.shape(0) > MOST_REGISTERS - STEP_INPUTS)
    throw std::invalid_argument("fold_value: more numbers than a step has");
  fold_value(op, inputs.data(), unsigned(inputs.shape(0)), repeat, number, outputs.data(), unsigned(outputs.shape(0)));
}

using Angles = nb::ndarray<const float, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

Atmosphere atmosphere_of(Angles numbers) {
  if (numbers.shape(0) != 5) throw std::invalid_argument("an atmosphere is five numbers");
  const float *n = numbers.data();
  return {n[0], n[1], n[2], n[3], n[4]};
}

void sky_of(bool often, Angles atmosphere, Angles latitudes, Angles longitudes, int threads, MutableFloats xyz) {
  size_t rows = latitudes.shape(0), columns = longitudes.shape(0);
  if (xyz.shape(0) != rows * columns) throw std::invalid_argument("scatter_sky: three numbers for each direction");
  Atmosphere a = atmosphere_of(atmosphere);
  nb::gil_scoped_release release;
  (often ? scatter_often : scatter_once)(a, latitudes.data(), int(rows), longitudes.data(), int(columns), threads, xyz.data());
}

void sun_of(bool often, Angles atmosphere, Angles elevations, MutableFloats xyz) {
  if (xyz.shape(0) != elevations.shape(0)) throw std::invalid_argument("shine_through: three numbers for each elevation");
  (often ? shine_often : shine_once)(atmosphere_of(atmosphere), elevations.data(), int(elevations.shape(0)), xyz.data());
}

void emission_of(const std::vector<Bytes> &buffers, nb::ndarray<const uint32_t, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu> ids,
                 nb::ndarray<const float, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu> places,
                 nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> directions, int threads,
                 nb::ndarray<float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> radiance) {
  size_t n = ids.shape(0);
  if (places.shape(0) != n || directions.shape(0) != n || radiance.shape(0) != n)
    throw std::invalid_argument("evaluate_emission: arrays of different lengths");
  std::vector<const void *> scene = pointers(buffers);
  nb::gil_scoped_release release;
  evaluate_emission(scene.data(), ids.data(), places.data(), directions.data(), long(n), threads, radiance.data());
}

void extinction_of(const std::vector<Bytes> &buffers, nb::ndarray<const uint32_t, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu> ids,
                   nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> places, int threads,
                   nb::ndarray<float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> extinction) {
  size_t n = ids.shape(0);
  if (places.shape(0) != n || extinction.shape(0) != n)
    throw std::invalid_argument("evaluate_volumes: arrays of different lengths");
  std::vector<const void *> scene = pointers(buffers);
  nb::gil_scoped_release release;
  evaluate_volumes(scene.data(), ids.data(), places.data(), long(n), threads, extinction.data());
}

void lamp_emission_of(const std::vector<Bytes> &buffers, nb::ndarray<const uint32_t, nb::shape<-1>, nb::c_contig, nb::device::cpu> lamps,
                      nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> origins,
                      nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> directions, int threads,
                      nb::ndarray<float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> emission) {
  size_t n = lamps.shape(0);
  if (origins.shape(0) != n || directions.shape(0) != n || emission.shape(0) != n)
    throw std::invalid_argument("evaluate_lamps: arrays of different lengths");
  std::vector<const void *> scene = pointers(buffers);
  nb::gil_scoped_release release;
  evaluate_lamps(scene.data(), lamps.data(), origins.data(), directions.data(), long(n), threads, emission.data());
}

void triangles_of(const MeshArrays &meshes, Uints order, Bytes last, int threads, MutableBytes to) {
  LeafTriangles leaves = meshes.leaves(order, last);
  if (to.shape(0) != leaves.count * sizeof(Triangle)) throw std::invalid_argument("make_triangles: a record for each");
  nb::gil_scoped_release release;
  make_triangles(leaves, reinterpret_cast<Triangle *>(to.data()), threads);
}

nb::tuple split(Uints vertex, Floats normals, size_t vertices, int threads) {
  if (vertex.shape(0) != normals.shape(0)) throw std::invalid_argument("split_vertices: a normal for each corner");
  for (size_t c = 0; c < vertex.shape(0); c++)
    if (vertex.data()[c] >= vertices) throw std::invalid_argument("split_vertices: no such vertex");
  SplitVertices made;
  {
    nb::gil_scoped_release release;
    made = split_vertices(vertex.data(), normals.data(), vertex.shape(0), vertices, threads);
  }
  return nb::make_tuple(to_array(std::move(made.corner)), to_array(std::move(made.origin)), to_array(std::move(made.normals), 3));
}

void bad_triangles(Floats vertices, Indices triangles, int threads, MutableBytes bad) {
  if (bad.shape(0) != triangles.shape(0)) throw std::invalid_argument("find_bad_triangles: one mark for each triangle");
  nb::gil_scoped_release release;
  find_bad_triangles(vertices.data(), triangles.data(), triangles.shape(0), bad.data(), threads);
}

void mesh_boxes(Floats vertices, Indices triangles, Uints mesh_triangles, int threads,
                nb::ndarray<float, nb::shape<-1, 2, 3>, nb::c_contig, nb::device::cpu> boxes) {
  if (mesh_triangles.shape(0) != boxes.shape(0) + 1) throw std::invalid_argument("find_mesh_boxes: a box for each mesh");
  nb::gil_scoped_release release;
  find_mesh_boxes(vertices.data(), triangles.data(), mesh_triangles.data(), boxes.shape(0), boxes.data(), threads);
}

nb::tuple fingerprint_of(Bytes bytes, int threads) {
  Fingerprint made;
  {
    nb::gil_scoped_release release;
    made = fingerprint(bytes.data(), bytes.size(), threads);
  }
  return nb::make_tuple(made.low, made.high);
}

size_t add_listed_to(nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu> hi,
                     nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu> lo,
                     nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu> values,
                     nb::ndarray<const int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> pixels) {
  size_t count = pixels.shape(0);
  if (values.shape(0) != count || (lo.shape(0) && lo.shape(0) != hi.shape(0)))
    throw std::invalid_argument("add_listed: a value for each pixel, halves of one size");
  auto [least, most] = std::minmax_element(pixels.data(), pixels.data() + count);
  if (count && (*least < 0 || size_t(*most) >= hi.shape(0))) throw std::invalid_argument("add_listed: no such pixel");
  nb::gil_scoped_release release;
  return add_listed(hi.data(), lo.shape(0) ? lo.data() : nullptr, values.data(), pixels.data(), count);
}

bool are_finite(nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu> values, int threads) {
  nb::gil_scoped_release release;
  return all_finite(values.data(), values.shape(0), threads);
}

nb::tuple refit(const MeshArrays &meshes, MutableBytes nodes, uint32_t root, Uints order, Bytes last, Floats lo, Floats hi,
                Uints reference, float margin, int threads) {
  size_t count = reference.shape(0);
  if (lo.shape(0) != count || hi.shape(0) != count) throw std::invalid_argument("refit_tree: a box for each reference");
  Leaves leaves{meshes.leaves(order, last), reference.data(), lo.data(), hi.data(), count, margin};
  TreeCost cost;
  {
    nb::gil_scoped_release release;
    cost = refit_tree(reinterpret_cast<Bvh2Node *>(nodes.data()), root, leaves, threads);
  }
  return nb::make_tuple(cost.before, cost.after);
}

}  // namespace

NB_MODULE(_native, m) {
  m.attr("version") = ISOPHOTE_VERSION;
  m.attr("compiler") = ISOPHOTE_COMPILER;
  nb::list variants;
  for (const Variant &v : VARIANTS) variants.append(nb::make_tuple(v.name, v.precision, v.level, is_supported(v.level)));
  m.attr("variants") = variants;
  nb::dict sizes;
#define X(type, name, comment) sizes[#name] = sizeof(type);
  SCENE_BUFFERS(X)
#undef X
  sizes["params"] = sizeof(Params);
  m.attr("sizes") = sizes;
  nb::class_<MeshArrays>(m, "Meshes")
      .def(nb::init<Floats, Indices, Uints, Bytes>(), nb::arg("vertices"), nb::arg("triangles"), nb::arg("first"), nb::arg("uses"))
      .def_prop_ro("triangle_count", [](const MeshArrays &m) { return m.view().triangle_count(); });
  m.def("make_tree", &make_tree, nb::arg("meshes"), nb::arg("members"), nb::arg("lo"), nb::arg("hi"), nb::arg("reference"),
        nb::arg("margin"), nb::arg("item_cost"), nb::arg("max_leaf"), nb::arg("threads"));
  m.def("time_tree", &time_tree, nb::arg("meshes"), nb::arg("members"), nb::arg("margin"), nb::arg("item_cost"),
        nb::arg("max_leaf"), nb::arg("threads"));
  nb::class_<WideTree>(m, "WideTree")
      .def_prop_ro("bytes", &wide_bytes)
      .def("triangles", [](const WideTree &tree, size_t part) { return tree.parts.at(part).triangles; }, nb::arg("part"));
  m.def("batch_bytes", [](const std::string &variant) { return find_variant(variant).batch_bytes(); }, nb::arg("variant"));
  m.def("make_wide_tree", &wide_tree, nb::arg("meshes"), nb::arg("sources"), nb::arg("tree_of"), nb::arg("threads"));
  m.def("refit_wide_tree", &refit_wide, nb::arg("meshes"), nb::arg("tree"), nb::arg("part"), nb::arg("lo"), nb::arg("hi"),
        nb::arg("reference"), nb::arg("margin"), nb::arg("threads"));
  m.def("render", &render, nb::arg("variant"), nb::arg("buffers"), nb::arg("tree"), nb::arg("params"), nb::arg("threads"),
        nb::arg("sums"), nb::arg("rays"), nb::arg("limits"), nb::arg("cancelled"));
  m.def("trace", &trace, nb::arg("variant"), nb::arg("buffers"), nb::arg("tree").none(),
        nb::arg("rays"), nb::arg("any"), nb::arg("threads"), nb::arg("packets") = false);
  m.def("bake_vertices", &bake_vertices_of, nb::arg("vertices"), nb::arg("first"), nb::arg("uses"), nb::arg("threads"),
        nb::arg("to"));
  m.def("bake_normals", &bake_normals_of, nb::arg("normals"), nb::arg("first_normal"), nb::arg("first"), nb::arg("uses"),
        nb::arg("threads"), nb::arg("to"));
  m.def("make_triangles", &triangles_of, nb::arg("meshes"), nb::arg("order"), nb::arg("last"), nb::arg("threads"), nb::arg("to"));
  m.def("split_vertices", &split, nb::arg("vertex"), nb::arg("normals"), nb::arg("vertices"), nb::arg("threads"));
  m.def("find_bad_triangles", &bad_triangles, nb::arg("vertices"), nb::arg("triangles"), nb::arg("threads"), nb::arg("bad"));
  m.def("find_mesh_boxes", &mesh_boxes, nb::arg("vertices"), nb::arg("triangles"), nb::arg("mesh_triangles"),
        nb::arg("threads"), nb::arg("boxes"));
  m.def("evaluate_emission", &emission_of, nb::arg("buffers"), nb::arg("ids"), nb::arg("places"), nb::arg("directions"),
        nb::arg("threads"), nb::arg("radiance"));
  m.def("evaluate_volumes", &extinction_of, nb::arg("buffers"), nb::arg("ids"), nb::arg("places"), nb::arg("threads"),
        nb::arg("extinction"));
  m.def("evaluate_lamps", &lamp_emission_of, nb::arg("buffers"), nb::arg("lamps"), nb::arg("origins"), nb::arg("directions"),
        nb::arg("threads"), nb::arg("emission"));
  m.def("fold_value", &fold, nb::arg("op"), nb::arg("inputs"), nb::arg("repeat"), nb::arg("number"), nb::arg("outputs"));
  m.def("scatter_sky", &sky_of, nb::arg("often"), nb::arg("atmosphere"), nb::arg("latitudes"), nb::arg("longitudes"),
        nb::arg("threads"), nb::arg("xyz"));
  m.def("shine_through", &sun_of, nb::arg("often"), nb::arg("atmosphere"), nb::arg("elevations"), nb::arg("xyz"));
  m.def("add_listed", &add_listed_to, nb::arg("hi"), nb::arg("lo"), nb::arg("values"), nb::arg("pixels"));
  m.def("fingerprint", &fingerprint_of, nb::arg("bytes"), nb::arg("threads"));
  m.def("all_finite", &are_finite, nb::arg("values"), nb::arg("threads"));
  m.def("refit_tree", &refit, nb::arg("meshes"), nb::arg("nodes"), nb::arg("root"), nb::arg("order"), nb::arg("last"),
        nb::arg("lo"), nb::arg("hi"), nb::arg("reference"), nb::arg("margin"), nb::arg("threads"));
}
