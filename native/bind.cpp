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
#include "isophote_build.h"
#include "refit.h"
#include "render.h"
#include "triangles.h"

namespace nb = nanobind;
using namespace isophote;

namespace isophote {
#define X(name, precision, level)                                                                       \
  namespace name {                                                                                      \
  bool render(const void *const *, const WideTree *, const void *, int, float *, uint64_t *, const std::atomic<int> *); \
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

using Corners = nb::ndarray<const float, nb::shape<-1, 3, 3>, nb::c_contig, nb::device::cpu>;

nb::tuple make_tree(Corners corners, Floats lo, Floats hi, Uints reference, float margin, uint32_t node_base,
                    uint32_t triangle_base, uint32_t sphere_base, int max_leaf, int threads) {
  size_t n = lo.shape(0);
  if (hi.shape(0) != n || reference.shape(0) != n)
    throw std::invalid_argument("make_tree: lo, hi and reference must have the same length");
  BuildInput input{corners.data(), corners.shape(0), lo.data(), hi.data(), reference.data(), n, margin};
  if (input.size() >> 30) throw std::invalid_argument("make_tree: a tree holds less than 2^30 items");
  Tree tree;
  {
    nb::gil_scoped_release release;
    tree = build_tree(input, {node_base, triangle_base, sphere_base}, max_leaf, threads);
  }
  return nb::make_tuple(to_bytes(std::move(tree.nodes)), to_array(std::move(tree.order)), to_array(std::move(tree.last)),
                        tree.root, tree.depth);
}

/* Seconds of the stages of building, as in Tree. */
std::vector<double> time_tree(Corners corners, float margin, int max_leaf, int threads) {
  nb::gil_scoped_release release;
  Tree tree = build_tree({corners.data(), corners.shape(0), nullptr, nullptr, nullptr, 0, margin}, {}, max_leaf, threads);
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

WideTree wide_tree(Bytes nodes, Bytes triangles, Bytes instances, uint32_t root, int threads) {
  nb::gil_scoped_release release;
  return make_wide_tree(reinterpret_cast<const Bvh2Node *>(nodes.data()), nodes.size() / sizeof(Bvh2Node),
                        reinterpret_cast<const Triangle *>(triangles.data()),
                        reinterpret_cast<const Instance *>(instances.data()), instances.size() / sizeof(Instance), root, threads);
}

bool render(const std::string &variant, const std::vector<Bytes> &buffers, const WideTree &tree, Bytes params, int threads,
            nb::ndarray<float, nb::ndim<3>, nb::c_contig, nb::device::cpu> sums,
            nb::ndarray<uint64_t, nb::shape<2>, nb::c_contig, nb::device::cpu> rays,
            nb::ndarray<int32_t, nb::shape<1>, nb::c_contig, nb::device::cpu> cancelled) {
  const Variant &v = find_variant(variant);
  const Params *p = reinterpret_cast<const Params *>(params.data());
  if (params.size() != sizeof(Params)) throw std::invalid_argument("render: params of the wrong size");
  size_t planes = p->aovs ? PLANES_ALL : PLANES_COMBINED;
  if (sums.shape(0) < planes || sums.shape(1) != size_t(p->height) || sums.shape(2) != size_t(p->width))
    throw std::invalid_argument("render: sums do not have the shape of the region");
  std::vector<const void *> scene = pointers(buffers);
  float *out = sums.data();
  uint64_t *counts = rays.data();
  auto *flag = reinterpret_cast<const std::atomic<int> *>(cancelled.data());
  nb::gil_scoped_release release;
  return v.render(scene.data(), &tree, p, threads, out, counts, flag);
}

nb::tuple trace(const std::string &variant, const std::vector<Bytes> &buffers, const WideTree *tree,
                nb::ndarray<const float, nb::shape<-1, 8>, nb::c_contig, nb::device::cpu> rays, bool any, int threads, bool packets) {
  const Variant &v = find_variant(variant);
  std::vector<const void *> scene = pointers(buffers);
  size_t n = rays.shape(0);
  std::vector<float> hits(4 * n);
  std::vector<uint32_t> ids(2 * n);
  {
    nb::gil_scoped_release release;
    v.trace(scene.data(), tree, rays.data(), long(n), any, threads, packets, hits.data(), ids.data());
  }
  return nb::make_tuple(to_array(std::move(hits), 4), to_array(std::move(ids), 2));
}

using Indices = nb::ndarray<const uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using MutableBytes = nb::ndarray<uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MutableUints = nb::ndarray<uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MutableCorners = nb::ndarray<float, nb::shape<-1, 3, 3>, nb::c_contig, nb::device::cpu>;

Parts parts_of(const Bytes &parts) {
  if (parts.size() % sizeof(Part)) throw std::invalid_argument("parts of the wrong size");
  return Parts(reinterpret_cast<const Part *>(parts.data()), parts.size() / sizeof(Part));
}

void bake(Floats vertices, Indices triangles, Bytes parts, int threads, MutableCorners corners) {
  Parts all = parts_of(parts);
  if (corners.shape(0) != all.size()) throw std::invalid_argument("bake_corners: corners do not fit the parts");
  SceneTriangles scene{vertices.data(), triangles.data(), nullptr, nullptr};
  nb::gil_scoped_release release;
  bake_corners(scene, all, corners.data(), threads);
}

void place(Uints slots, Corners normals, Bytes parts, Corners corners, Uints order, Bytes last, int threads,
           MutableBytes placed, MutableUints normal_index, MutableBytes placed_normals) {
  Parts all = parts_of(parts);
  size_t count = order.shape(0); /* more than triangles, where some are in several leaves */
  if (count < all.size() || last.shape(0) != count || corners.shape(0) != all.size() || normal_index.shape(0) != count ||
      placed.shape(0) != count * sizeof(Triangle) ||
      placed_normals.shape(0) != all.smooth(order.data(), count) * sizeof(CornerNormals))
    throw std::invalid_argument("place_triangles: arrays do not fit the parts");
  PlacedTriangles out{reinterpret_cast<Triangle *>(placed.data()), normal_index.data(),
                      reinterpret_cast<CornerNormals *>(placed_normals.data())};
  SceneTriangles scene{nullptr, nullptr, slots.data(), normals.data()};
  nb::gil_scoped_release release;
  place_triangles(scene, all, corners.data(), order.data(), last.data(), count, threads, out);
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

bool same(Bytes a, Bytes b, int threads) {
  nb::gil_scoped_release release;
  return a.size() == b.size() && same_bytes(a.data(), b.data(), a.size(), threads);
}

bool are_finite(nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu> values, int threads) {
  nb::gil_scoped_release release;
  return all_finite(values.data(), values.shape(0), threads);
}

nb::tuple refit(MutableBytes nodes, uint32_t root, Bytes triangles, Bytes spheres, Uints instances, Floats lo, Floats hi,
                float margin, int threads) {
  size_t count = instances.shape(0);
  if (lo.shape(0) != count || hi.shape(0) != count) throw std::invalid_argument("refit_tree: a box for each instance");
  Leaves leaves{reinterpret_cast<const Triangle *>(triangles.data()), reinterpret_cast<const Sphere *>(spheres.data()),
                instances.data(), lo.data(), hi.data(), count, margin};
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
  m.def("make_tree", &make_tree, nb::arg("corners"), nb::arg("lo"), nb::arg("hi"), nb::arg("reference"),
        nb::arg("margin"), nb::arg("node_base"), nb::arg("triangle_base"), nb::arg("sphere_base"), nb::arg("max_leaf"), nb::arg("threads"));
  m.def("time_tree", &time_tree, nb::arg("corners"), nb::arg("margin"), nb::arg("max_leaf"), nb::arg("threads"));
  nb::class_<WideTree>(m, "WideTree").def_prop_ro("bytes", &wide_bytes);
  m.def("batch_bytes", [](const std::string &variant) { return find_variant(variant).batch_bytes(); }, nb::arg("variant"));
  m.def("make_wide_tree", &wide_tree, nb::arg("nodes"), nb::arg("triangles"), nb::arg("instances"), nb::arg("root"),
        nb::arg("threads"));
  m.def("render", &render, nb::arg("variant"), nb::arg("buffers"), nb::arg("tree"), nb::arg("params"), nb::arg("threads"),
        nb::arg("sums"), nb::arg("rays"), nb::arg("cancelled"));
  m.def("trace", &trace, nb::arg("variant"), nb::arg("buffers"), nb::arg("tree").none(),
        nb::arg("rays"), nb::arg("any"), nb::arg("threads"), nb::arg("packets") = false);
  m.def("bake_corners", &bake, nb::arg("vertices"), nb::arg("triangles"), nb::arg("parts"), nb::arg("threads"),
        nb::arg("corners"));
  m.def("place_triangles", &place, nb::arg("slots"), nb::arg("normals"), nb::arg("parts"), nb::arg("corners"),
        nb::arg("order"), nb::arg("last"), nb::arg("threads"), nb::arg("placed"), nb::arg("normal_index"),
        nb::arg("placed_normals"));
  m.def("find_bad_triangles", &bad_triangles, nb::arg("vertices"), nb::arg("triangles"), nb::arg("threads"), nb::arg("bad"));
  m.def("find_mesh_boxes", &mesh_boxes, nb::arg("vertices"), nb::arg("triangles"), nb::arg("mesh_triangles"),
        nb::arg("threads"), nb::arg("boxes"));
  m.def("same_bytes", &same, nb::arg("a"), nb::arg("b"), nb::arg("threads"));
  m.def("all_finite", &are_finite, nb::arg("values"), nb::arg("threads"));
  m.def("refit_tree", &refit, nb::arg("nodes"), nb::arg("root"), nb::arg("triangles"), nb::arg("spheres"),
        nb::arg("instances"), nb::arg("lo"), nb::arg("hi"), nb::arg("margin"), nb::arg("threads"));
}
