/* The founding report's experiments: the shipping kernels with another tracer, and other schedules around them.
 *
 * The host (bench/study) defines TRAVERSAL, one of the numbers below, the macros that its header names, and which of the
 * files at the end are wanted. Every tracer gives the hits of the shipping one, every schedule its sums. Not part of the
 * shipped program. */
/* With the shipping trace(), whose name another tracer takes below. Headers that several of the conditions below want
 * are named here: the host puts each in once, where it is first named. */
#include "../bvh.h"
#include "box.h"

#define TRAVERSAL_SHIPPING 0
#define TRAVERSAL_LIST 1
#define TRAVERSAL_STACK 2
#define TRAVERSAL_STACKLESS 3
#define TRAVERSAL_WIDE4 4
#define TRAVERSAL_WIDE8 5

#if TRAVERSAL == TRAVERSAL_WIDE4 || TRAVERSAL == TRAVERSAL_WIDE8
#include "wide.h"
#endif
#if TRAVERSAL == TRAVERSAL_LIST
#include "list.h"
#define trace(scene, ray, any) trace_list(scene, ray, any)
#elif TRAVERSAL == TRAVERSAL_STACK
#include "stack.h"
#define trace(scene, ray, any) trace_stack(scene, ray, any)
#elif TRAVERSAL == TRAVERSAL_STACKLESS
#include "stackless.h"
#define trace(scene, ray, any) trace_stackless(scene, ray, any)
#elif TRAVERSAL == TRAVERSAL_WIDE4
#include "wide4.h"
#define trace(scene, ray, any) trace_wide4(scene, ray, any)
#elif TRAVERSAL == TRAVERSAL_WIDE8
#include "wide8.h"
#define trace(scene, ray, any) trace_wide8(scene, ray, any)
#endif

#if TRAVERSAL != TRAVERSAL_SHIPPING
/* In place of the shipping walk: all of it at once. */
FN void walk_to_end(Walk *w, Scene s, int any) {
  w->best = trace(s, w->ray, any);
  w->ref = NONE;
}
#define go_on(walk, stack, scene, any, company) walk_to_end(walk, scene, any)
#endif

#include "../wavefront.cl"

#if MEGAKERNEL
#include "megakernel.cl"
#endif
#if PLACES
#include "slots.cl"
#include "reorder.cl"
#endif
#if SORT
#include "sort.cl"
#endif
#if BREADTH_FIRST
#include "breadth_first.cl"
#endif
