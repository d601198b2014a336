"""Chains of rods on universal joints: accelerations and every joint's reactions in O(n) (docs/derivation_chain.md).

kinematics: frames, positions. system: the balances, and how they are solved. solution: rods on universal joints. thin: thin
rods in directions, and their angles. May import: the ground, no other route.
"""
