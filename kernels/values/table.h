/* Tables: functions of one number, curves and ramps, as entries at even distances from 0 to 1. A step's `data` is the
 * first entry in value_tables, its `number` how many there are, at least 2. */
#ifndef ISOPHOTE_VALUES_TABLE_H
#define ISOPHOTE_VALUES_TABLE_H
#include "value.h"

/* X(number, name, inputs, outputs) */
#define VALUES_TABLE(X)       \
  X(216, table, 1, 1)         \
  X(217, table_extended, 1, 1) \
  X(218, table_stepped, 1, 1)

FN real table_entry(Scene s, ValueStep o, uint place) { return to_real(s.value_tables[o.data + place]); }

FN real read_table(Scene s, ValueStep o, real x) {
  uint last = uint_of(int_of(o.number)) - 1u;
  real place = clamp01(x) * real_of(int_of(last));
  uint before = uint_of(int_of(place));
  real along = place - real_of(int_of(before));
  return table_entry(s, o, before) * (REAL(1.0) - along) + table_entry(s, o, min_uint(before + 1u, last)) * along;
}

/* Interpolated; beyond the ends, their entries. */
VALUE(table) { OUT(0) = read_table(s, o, IN(0)); }
/* Interpolated; beyond the ends straight on. */
VALUE(table_extended) {
  real x = IN(0);
  uint last = uint_of(int_of(o.number)) - 1u;
  real low = table_entry(s, o, 0u), high = table_entry(s, o, last), steps = real_of(int_of(last));
  real before = low + (table_entry(s, o, 1u) - low) * (x * steps);
  real after = high + (high - table_entry(s, o, last - 1u)) * ((x - REAL(1.0)) * steps);
  OUT(0) = x < REAL(0.0) ? before : x > REAL(1.0) ? after : read_table(s, o, x);
}
/* The entry before the place. */
VALUE(table_stepped) {
  real last = to_real(o.number) - REAL(1.0);
  OUT(0) = table_entry(s, o, uint_of(int_of(clamp01(IN(0)) * last)));
}

#endif
