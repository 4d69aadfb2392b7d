/* Boxes as nodes hold them and the kernels' test of them, over arrays, for tests/unit/test_boxes.py. */
#include "../../kernels/bvh.h"
#include "../../native/bvh_node.h"

/* Whether n rays (origin 3, direction 3) meet their boxes (low 3, high 3) in front of t_max. */
extern "C" void probe_boxes(int n, const float *rays, const float *boxes, const float *t_max, int *met) {
  for (int i = 0; i < n; i++, rays += 6, boxes += 6) {
    Bvh2Node node;
    isophote::set_box(node, 0, boxes, boxes + 3);
    LocalRay ray = make_local_ray(make_real3(rays[0], rays[1], rays[2]), make_real3(rays[3], rays[4], rays[5]));
    Span span = span_of_box(node.center_x[0], node.half_x[0], node.center_y[0], node.half_y[0], node.center_z[0],
                            node.half_z[0], ray, 0.0f, t_max[i] * LIMIT_SLACK);
    met[i] = span.enter <= span.leave;
  }
}
