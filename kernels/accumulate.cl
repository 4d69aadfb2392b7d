/* The entry point that adds finished paths to the film's sums; part of wavefront.cl. */

/* Adds the samples of each pixel to the film in the order of their numbers; those that are no numbers count as 0. */
__kernel void accumulate(GLOBAL const Params *params_buffer, uint stride, RESULT_PARAMETERS, GLOBAL float *sums,
                         uint first_pixel, uint pixels) {
  Params params = params_buffer[0];
  uint k = get_global_id(0);
  if (k < LIMITS) { /* one work-item each: totals with a carry */
    uint total = limits[LIMITS + k] + limits[k];
    limits[2u * LIMITS + k] += total < limits[k] ? 1u : 0u;
    limits[LIMITS + k] = total;
    limits[k] = 0u;
  }
  if (k >= pixels) return;
  uint plane = uint_of(params.width) * uint_of(params.height), groups = film_groups(params);
  uint at = first_pixel + k;
  uint first_sample = params.first_sample + (params.listed ? listed_pixels(params_buffer)[at].first : 0u);
  for (uint n = 0u; n < params.samples; n++) {
    uint slot = k * params.samples + n, sample = first_sample + n;
    uint first = (PLANE_COMBINED + 4u * (sample & 1u)) * plane + at;
    int valid = 1;
    for (uint c = 0u; c < (CLAMPS ? 6u : 4u); c++) valid &= is_addable(results[c * stride + slot]);
    if (valid) {
      for (uint c = 0u; c < 4u; c++) sums[first + c * plane] += results[c * stride + slot];
      if (CLAMPS)
        for (uint c = 0u; c < 2u; c++)
          sums[(uint_of(params.cut_plane) + 2u * (sample & 1u) + c) * plane + at] += results[(4u + c) * stride + slot];
    }
    int lit = valid;
    for (uint a = PLANES_COMBINED; a < planes_end(groups); a++) {
      real value = columns[(a - PLANES_COMBINED) * stride + slot];
      valid &= is_addable(value);
      if (plane_takes(groups, a, sample) & is_addable(value) & (lit | (a < first_light_plane(groups))))
        sums[a * plane + at] += value;
    }
    if (has_any(groups, GROUPS_AOVS | GROUPS_LIGHT_GROUPS)) {
      for (int a = 0; a < params.named_planes; a++) {
        real value = columns[(pass_columns(groups) + uint_of(a)) * stride + slot];
        valid &= is_addable(value);
        if (is_addable(value) & (lit | (a < params.light_plane))) sums[(planes_end(groups) + uint_of(a)) * plane + at] += value;
      }
    }
    if (has_any(groups, GROUPS_MATTES))
      add_mattes(sums + first_matte_plane(params) * plane + at, plane, columns + first_matte(groups) * stride + slot, stride,
                 params.matte_rows, matte_kinds(groups));
    if (!valid) sums[PLANE_INVALID * plane + at] += 1.0f;
  }
}
