/* Embree's builders behind one C function, for bench/build.py. */
#include <embree3/rtcore.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>

namespace {
std::atomic<long> used;
bool count(void *, ssize_t bytes, bool) {
  used += bytes;
  return true;
}
}  // namespace

/* Seconds of committing a scene of one mesh with RTC_BUILD_QUALITY_MEDIUM (1) or _HIGH (2), Embree's thread pool
 * being up; `bytes` receives what the scene then holds, without the mesh's own arrays. Negative where it fails. */
extern "C" double build(const float *vertices, size_t vertex_count, const unsigned *triangles, size_t triangle_count,
                        int quality, int threads, long *bytes) {
  char config[64];
  snprintf(config, sizeof config, "threads=%d,start_threads=1", threads);
  RTCDevice device = rtcNewDevice(config);
  if (!device) return -1.0;
  rtcSetDeviceMemoryMonitorFunction(device, count, nullptr);
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, quality == 2 ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertex_count), vertices,
         12 * vertex_count);
  memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangle_count), triangles,
         12 * triangle_count);
  rtcCommitGeometry(mesh);
  rtcAttachGeometry(scene, mesh);
  long before = used;
  auto started = std::chrono::steady_clock::now();
  rtcCommitScene(scene);
  double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  *bytes = used - before;
  bool failed = rtcGetDeviceError(device) != RTC_ERROR_NONE;
  rtcReleaseGeometry(mesh);
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return failed ? -1.0 : seconds;
}
