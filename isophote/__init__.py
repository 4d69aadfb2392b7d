"""Isophote: a path tracer that says how accurate its pictures are."""
