"""Chains of rods on universal joints: accelerations and every joint's reactions in O(n) (docs/derivation_chain.md).

kinematics and angles: frames, positions, angles. system: the balances, and how they are solved. solution: rods on universal
joints. thin: thin rods, in directions. May import: the ground, no other route.
"""
