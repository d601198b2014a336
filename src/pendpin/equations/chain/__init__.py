"""Chains of rods on universal joints: accelerations and every joint's reactions in O(n) (docs/derivation_chain.md)."""
