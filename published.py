"""Printed numbers of both papers that the package uses.

Numbers that only the repeated experiments use are in `reproductions`.

Li et al. 2022: Z. Li et al., "Jiles-Atherton-based hysteresis identification of joint resistant
torque in active spacesuit using SA-PSO algorithm", Int. J. Aerospace Eng. 7535450 (2022).
Kao and Fung 2009: C.-C. Kao and R.-F. Fung, "Using the modified PSO method to identify a
Scott-Russell mechanism actuated by a piezoelectric element", Mech. Syst. Signal Process. 23 (2009).
"""

# Li et al. 2022, sections 3.1 and 5.1: the lowest angle, where every curve begins, and where the
# first-order curves turn back [rad].
LI_LOWEST = {"shoulder": 0.35, "elbow": 0.52}
LI_TURNS = {
    "shoulder": (0.52, 0.70, 0.87, 1.05, 1.22),
    "elbow": (0.87, 1.05, 1.22, 1.40, 1.57),
}
LI_RANGES = {joint: (LI_LOWEST[joint], turns[-1]) for joint, turns in LI_TURNS.items()}

# Table 1: the search bounds of Ms [N·m], a [deg], alpha [deg/(N·m)], c, k [deg].
LI_BOUNDS = ((1.0, 100.0), (1.0, 5000.0), (-10.0, 10.0), (-10.0, 10.0), (1.0, 2000.0))
# Table 2: the identified Ms, a, alpha, c, k in the same units, by joint and method.
LI_TABLE_2 = {
    "shoulder-mpso": (75.0927, 2910.71, 9.455, 8.8561, 652.0938),
    "shoulder-sa-pso": (22.2316, 319.55, 6.3223, 4.7447, 168.582),
    "elbow-mpso": (51.2134, 1213.65, 5.5624, 5.9824, 166.8229),
    "elbow-sa-pso": (11.4488, 128.97, -0.0515, 6.4043, 23.0945),
}

# Kao and Fung 2009, section 4.4: inertia, cognitive and social coefficient.
KAO_INERTIA, KAO_COGNITIVE, KAO_SOCIAL = 0.65, 0.7, 2.05
