"""Tools for a class: checks, editions, hand-outs, a course, a contest, the doctor."""
