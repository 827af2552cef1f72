"""lambert.py with a density that is 2 % too large, which the checks must detect."""
import lambert

honest = lambert.pdf
lambert.pdf = lambda wo, wi: 1.02 * honest(wo, wi)
lambert.main()
