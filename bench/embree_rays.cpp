/* Embree for bench/rays.py: a scene of one mesh, and loops over rays around rtcIntersect and rtcOccluded.
 *
 * Compiled by the bench. The library is opened by path and the few structs are declared here, so that one
 * program runs Embree 3 (as Debian has it) and Embree 4 (as the embreex wheel has it) without headers. */
#include <dlfcn.h>

#include <cstddef>
#include <cstdio>
#include <cstring>

namespace {

constexpr unsigned INVALID = 0xffffffffu;
constexpr int SINGLE = 1, PACKET = 16;

template <int N>
struct alignas(N == 1 ? 16 : 64) RayHit { /* RTCRayHit (N = 1) and RTCRayHit16 */
  float org_x[N], org_y[N], org_z[N], tnear[N], dir_x[N], dir_y[N], dir_z[N], time[N], tfar[N];
  unsigned mask[N], id[N], flags[N];
  float ng_x[N], ng_y[N], ng_z[N], u[N], v[N];
  unsigned prim[N], geom[N], inst[N], inst_prim[N]; /* the last one since 4.1 */
};

struct Context3 { /* RTCIntersectContext of Embree 3 */
  unsigned flags;
  void *filter;
  unsigned instance[2];
};
struct Arguments4 { /* RTCIntersectArguments and RTCOccludedArguments of Embree 4 */
  unsigned flags, features;
  void *context, *filter, *intersect;
  float min_width;
};

struct Library {
  void *handle;
  int version;
  template <typename F>
  F symbol(const char *name) const {
    return reinterpret_cast<F>(dlsym(handle, name));
  }
};

template <int N>
void load(RayHit<N> &r, const float *rays, long first, long n, int *valid) {
  for (int k = 0; k < N; k++) {
    bool in = first + k < n;
    const float *from = rays + 8 * (in ? first + k : first);
    valid[k] = in ? -1 : 0;
    r.org_x[k] = from[0], r.org_y[k] = from[1], r.org_z[k] = from[2];
    r.dir_x[k] = from[3], r.dir_y[k] = from[4], r.dir_z[k] = from[5];
    r.tnear[k] = from[6], r.tfar[k] = from[7];
    r.time[k] = 0.0f, r.mask[k] = INVALID, r.id[k] = unsigned(k), r.flags[k] = 0;
    r.geom[k] = r.prim[k] = r.inst[k] = r.inst_prim[k] = INVALID;
  }
}

/* hits: n x 3 floats t, u, v; ids: n primitives, INVALID where nothing is hit (any: 0 where something is). */
template <int N>
void store(const RayHit<N> &r, long first, long n, bool any, float *hits, unsigned *ids) {
  for (int k = 0; k < N && first + k < n; k++) {
    long i = first + k;
    ids[i] = any ? (r.tfar[k] < 0.0f ? 0 : INVALID) : r.geom[k] == INVALID ? INVALID : r.prim[k];
    hits[3 * i] = r.tfar[k], hits[3 * i + 1] = r.u[k], hits[3 * i + 2] = r.v[k];
  }
}

template <int N>
void loop(const Library &library, void *scene, const float *rays, long n, bool any, bool coherent, float *hits, unsigned *ids) {
  alignas(64) int valid[N];
  RayHit<N> r;
  Context3 context{coherent ? 1u : 0u, nullptr, {INVALID, INVALID}};
  Arguments4 arguments{coherent ? 1u << 16 : 0u, INVALID, nullptr, nullptr, nullptr, 0.0f};
  void *extra = library.version == 3 ? static_cast<void *>(&context) : static_cast<void *>(&arguments);
  auto each = [&](auto call) {
    for (long i = 0; i < n; i += N) {
      load(r, rays, i, n, valid);
      call();
      store(r, i, n, any, hits, ids);
    }
  };
  if constexpr (N == 1) {
    using F = void (*)(void *, void *, void *);
    F f = library.symbol<F>(any ? "rtcOccluded1" : "rtcIntersect1");
    if (library.version == 3) each([&] { f(scene, extra, &r); });
    else each([&] { f(scene, &r, extra); });
  } else {
    using F = void (*)(const int *, void *, void *, void *);
    F f = library.symbol<F>(any ? "rtcOccluded16" : "rtcIntersect16");
    if (library.version == 3) each([&] { f(valid, scene, extra, &r); });
    else each([&] { f(valid, scene, &r, extra); });
  }
}

struct Embree {
  Library library;
  void *device, *scene;
};

}  // namespace

extern "C" {

/* A scene of n triangles (n x 9 floats); quality 1 medium, 2 high; robust and compact are scene flags.
 * version: at least five digits of room for "x.y.z". Returns nullptr where the library is not Embree. */
void *embree_open(const char *path, const char *config, const float *corners, long n, int quality, int robust, int compact,
                  char *version) {
  Library l{dlopen(path, RTLD_NOW | RTLD_LOCAL), 0};
  if (!l.handle || !l.symbol<void *>("rtcNewDevice")) {
    std::fprintf(stderr, "%s\n", dlerror());
    return nullptr;
  }
  void *device = l.symbol<void *(*)(const char *)>("rtcNewDevice")(config);
  long number = l.symbol<long (*)(void *, int)>("rtcGetDeviceProperty")(device, 0);
  l.version = int(number / 10000);
  std::snprintf(version, 16, "%ld.%ld.%ld", number / 10000, number / 100 % 100, number % 100);
  void *scene = l.symbol<void *(*)(void *)>("rtcNewScene")(device);
  l.symbol<void (*)(void *, int)>("rtcSetSceneBuildQuality")(scene, quality);
  l.symbol<void (*)(void *, int)>("rtcSetSceneFlags")(scene, (compact ? 2 : 0) | (robust ? 4 : 0));
  void *geometry = l.symbol<void *(*)(void *, int)>("rtcNewGeometry")(device, 0);
  auto buffer = l.symbol<void *(*)(void *, int, unsigned, int, size_t, size_t)>("rtcSetNewGeometryBuffer");
  auto *vertices = static_cast<float *>(buffer(geometry, 1, 0, 0x9003, 12, size_t(3 * n)));
  std::memcpy(vertices, corners, size_t(n) * 36);
  auto *indices = static_cast<unsigned *>(buffer(geometry, 0, 0, 0x5003, 12, size_t(n)));
  for (long i = 0; i < 3 * n; i++) indices[i] = unsigned(i);
  l.symbol<void (*)(void *)>("rtcCommitGeometry")(geometry);
  l.symbol<unsigned (*)(void *, void *)>("rtcAttachGeometry")(scene, geometry);
  l.symbol<void (*)(void *)>("rtcReleaseGeometry")(geometry);
  l.symbol<void (*)(void *)>("rtcCommitScene")(scene);
  return new Embree{l, device, scene};
}

void embree_trace(void *embree, const float *rays, long n, int any, int packets, float *hits, unsigned *ids) {
  auto *e = static_cast<Embree *>(embree);
  if (packets)
    loop<PACKET>(e->library, e->scene, rays, n, any, true, hits, ids);
  else
    loop<SINGLE>(e->library, e->scene, rays, n, any, false, hits, ids);
}

void embree_close(void *embree) {
  auto *e = static_cast<Embree *>(embree);
  e->library.symbol<void (*)(void *)>("rtcReleaseScene")(e->scene);
  e->library.symbol<void (*)(void *)>("rtcReleaseDevice")(e->device);
  delete e;
}
}
