/* Tracing without a tree: sixteen rays at a time meet all triangles, where these are so few that a walk costs more.
 *
 * Rays are put together by the largest axis of their direction, so that the test's permutation of axes is the same
 * for the sixteen; otherwise they may go any way. */
#pragma once
#include "wide_packet.h"

namespace isophote {
namespace ISOPHOTE_VARIANT {

/* In blocks of four triangles; up to here all of them took less time than the tree (docs/study-cpu-tracing.md). */
constexpr size_t FEW_BLOCKS = 32;

/* As trace_wide, in trees of triangles of the world only. */
template <typename Source>
static void trace_few(const WideTree &tree, Source &source, uint count) {
  constexpr uint CHUNK = 1024;
  struct Listed {
    Source &source;
    const uint *numbers;
    Ray ray(uint i) const { return source.ray(numbers[i]); }
  };
  uint numbers[3][CHUNK];
  Packet p;
  for (uint first = 0; first < count; first += CHUNK) {
    uint listed[3] = {0, 0, 0}, end = count - first < CHUNK ? count : first + CHUNK;
    for (uint i = first; i < end; i++) {
      int axis = largest_axis(source.ray(i).direction);
      numbers[axis][listed[axis]++] = i;
    }
    for (int axis = 0; axis < 3; axis++) {
      for (uint from = 0; from < listed[axis]; from += PACKET) {
        uint n = listed[axis] - from < PACKET ? listed[axis] - from : PACKET;
        load_packet(p, Listed{source, numbers[axis]}, from, n);
        start_packet(p);
        for (const TriangleBlock &b : tree.blocks) hit_block<EDGES_AND_DISTANCE>(p, b);
        for (uint k = 0; k < n; k++) source.store(numbers[axis][from + k], hit_of(p, k));
      }
    }
  }
}

}  // namespace ISOPHOTE_VARIANT
}  // namespace isophote
