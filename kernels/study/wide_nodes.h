/* Nodes with four and eight children, plain and quantised; 4-byte scalars only, read by bench/study/trees.py too.
 *
 * Quantised boxes are those of Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", HPG, section 3: 8 bits a bound, in steps of a power of two from the node's corner. Unlike
 * there, references stand in full, so that instances and spheres need no table. Empty places hold NONE. */
#ifndef ISOPHOTE_STUDY_WIDE_NODES_H
#define ISOPHOTE_STUDY_WIDE_NODES_H
#include "../scene_records.h"

typedef struct {
  float lo_x[4], hi_x[4], lo_y[4], hi_y[4], lo_z[4], hi_z[4];
  uint child[4];
  uint unused[4];
} PlainNode4; /* 128 bytes */

typedef struct {
  packed3 corner;
  uint exponents; /* of the steps along x, y, z: biased, 8 bits each; then a bit a child that is there, of eight */
  uint child[4];
  uint lo_x, hi_x, lo_y, hi_y, lo_z, hi_z; /* a byte a child, in steps */
  uint unused[2];
} QuantisedNode4; /* 64 bytes: four children in the room of a BVH2's two */

typedef struct {
  packed3 corner;
  uint exponents;
  uint child[8]; /* placed so that a ray visits them in the order of their number, exclusive-or its octant */
  uint lo_x[2], hi_x[2], lo_y[2], hi_y[2], lo_z[2], hi_z[2];
} QuantisedNode8; /* 96 bytes */

#endif
