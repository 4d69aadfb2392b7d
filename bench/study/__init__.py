"""The founding report's experiments, run again: variants of traversal and schedule behind one interface."""
