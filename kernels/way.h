/* A path on its way below a surface, for devices whose lanes take one flight after the other. Functions change it in
 * place, as those of bvh.h do their walks. */
#ifndef ISOPHOTE_WAY_H
#define ISOPHOTE_WAY_H
#include "walk.h"

typedef struct {
  int inside;
  Path path;
  Medium medium;
  Walker walker;
  Flight flight;
  uint number;
} Way;

FN void start_way(Way *way, Path p, Medium m) {
  way->path = p;
  way->medium = m;
  way->walker = start_walker(p);
  way->number = 0u;
}

FN Ray next_ray(Way *way) {
  way->flight = draw_flight(way->medium, way->walker, way->number, way->path.seed, way->path.index);
  return ray_of_flight(way->path, way->medium, way->walker, way->flight, way->number);
}

FN int end_flight(Way *way, Hit h) {
  Flown r = fly(way->medium, way->walker, way->flight, h, way->number);
  way->walker = r.walker;
  way->number++;
  return r.state;
}

#endif
