"""Tools for a class: editions, hand-outs, marking that trusts nobody, and the offline bundle."""
