"""The numbers of both papers as printed; every other module takes them from here.

Li et al. 2022: Z. Li et al., "Jiles-Atherton-based hysteresis identification of joint resistant
torque in active spacesuit using SA-PSO algorithm", Int. J. Aerospace Eng. 7535450 (2022).
Kao and Fung 2009: C.-C. Kao and R.-F. Fung, "Using the modified PSO method to identify a
Scott-Russell mechanism actuated by a piezoelectric element", Mech. Syst. Signal Process. 23 (2009).
"""

from dataclasses import dataclass
from typing import Literal

# Li et al. 2022, sections 3.1 and 5.1: the lowest angle, where every curve begins, and where the
# first-order curves turn back [rad].
LI_LOWEST = {"shoulder": 0.35, "elbow": 0.52}
LI_TURNS = {
    "shoulder": (0.52, 0.70, 0.87, 1.05, 1.22),
    "elbow": (0.87, 1.05, 1.22, 1.40, 1.57),
}
LI_RANGES = {joint: (LI_LOWEST[joint], turns[-1]) for joint, turns in LI_TURNS.items()}
# Section 5.3: the turns of the curves that the identified models predict [rad].
LI_PREDICTED_TURNS = {"shoulder": (0.70, 1.05), "elbow": (1.05, 1.40)}

# Table 1: the search bounds of Ms [N·m], a [deg], alpha [deg/(N·m)], c, k [deg].
LI_BOUNDS = ((1.0, 100.0), (1.0, 5000.0), (-10.0, 10.0), (-10.0, 10.0), (1.0, 2000.0))
# Table 2: the identified Ms, a, alpha, c, k in the same units, by joint and method.
LI_TABLE_2 = {
    "shoulder-mpso": (75.0927, 2910.71, 9.455, 8.8561, 652.0938),
    "shoulder-sa-pso": (22.2316, 319.55, 6.3223, 4.7447, 168.582),
    "elbow-mpso": (51.2134, 1213.65, 5.5624, 5.9824, 166.8229),
    "elbow-sa-pso": (11.4488, 128.97, -0.0515, 6.4043, 23.0945),
}


@dataclass(frozen=True)
class LiClaim:
    """A claim of section 5 of Li et al. 2022: SA-PSO does better than MPSO.

    Attributes:
        joint: "shoulder" or "elbow".
        quantity: Name of the compared quantity; less is better in each.
        advantage: (MPSO - SA-PSO) / SA-PSO as printed; 0 where no percentage is printed.
        printed: Claim as the paper words it.
    """

    joint: str
    quantity: Literal["convergence", "fitness", "prediction"]
    advantage: float
    printed: str


LI_CLAIMS = (
    LiClaim("shoulder", "convergence", 0.0625, "converges 6.25 % earlier: iteration 48 against 51"),
    LiClaim("shoulder", "fitness", 0.1445, "best fitness 14.45 % better: 1.5473 against 1.7709"),
    LiClaim("elbow", "convergence", 0.2029, "converges 20.29 % earlier: iteration 69 against 83"),
    LiClaim("elbow", "fitness", 0.465, "best fitness 46.5 % better: 1.1770 against 1.7243"),
    LiClaim(
        "shoulder",
        "prediction",
        0.0,
        "predicts better: largest errors 1.39 and 0.41 N·m against 1.84 and 2.95",
    ),
    LiClaim(
        "elbow",
        "prediction",
        0.0,
        "predicts better: largest errors 1.84 and 0.79 N·m against 0.91 and 1.08",
    ),
)

# Kao and Fung 2009, section 4.4: inertia, cognitive and social coefficient, and the population.
KAO_INERTIA, KAO_COGNITIVE, KAO_SOCIAL = 0.65, 0.7, 2.05
KAO_POPULATION, KAO_ITERATIONS = 10_000, 100  # section 4.4 and figure 8
# Section 4.3, the cost benchmark: particles and iterations.
KAO_COST_SWARM, KAO_COST_ITERATIONS = 100, 100
# Its three units are those of D. C. Walters and G. B. Sheble, "Genetic algorithm solution of
# economic dispatch with valve point loading", IEEE Trans. Power Syst. 8 (1993): the demand [MW],
# and per unit the lowest and highest output [MW] and the coefficients of the cost [$/h].
WALTERS_DEMAND = 850.0
WALTERS_LOWEST = (100.0, 100.0, 50.0)
WALTERS_HIGHEST = (600.0, 400.0, 200.0)
WALTERS_A = (561.0, 310.0, 78.0)
WALTERS_B = (7.92, 7.85, 7.97)
WALTERS_C = (0.001562, 0.00194, 0.00482)
WALTERS_E = (300.0, 200.0, 150.0)
WALTERS_F = (0.0315, 0.042, 0.063)


@dataclass(frozen=True)
class KaoCosts:
    """One column of Table 1 of Kao and Fung 2009: 100 trials of 100 iterations.

    Attributes:
        best: Lowest cost [$/h].
        average: Mean cost [$/h].
        worst: Highest cost [$/h].
        reached: Number of trials that reached the optimum.
        iterations: Average number of iterations to converge.
        seconds: Average time of a trial on the authors' machine [s].
    """

    best: float
    average: float
    worst: float
    reached: int
    iterations: int
    seconds: float


KAO_TABLE_1 = {
    "pso": KaoCosts(8234.2507, 8241.4033, 8250.2047, 21, 47, 0.2473),
    "rank-distance-mpso": KaoCosts(8233.6607, 8234.1267, 8234.2046, 35, 21, 0.1971),
}

# Table 2: (case, method) -> m [kg], c [N s/m], k [N/m], d_e [m/V], alpha, beta, gamma [1/V^n]. The
# paper does not print the n of its case "n free".
KAO_TABLE_2 = {
    ("n = 1", "mpso"): (0.1025, 57.665, 4180.5, 2.1672e-7, 0.2161, 0.00504, 0.0239),
    ("n = 1", "pso"): (0.1, 60.0, 4497.0, 2.17481e-7, 0.2112, 0.005, 0.0299),
    ("n free", "mpso"): (0.1008, 55.905, 4093.5, 2.1603e-7, 0.1815, 0.005, 0.0237),
    ("n free", "pso"): (0.1, 58.074, 4499.0, 2.168e-7, 0.198, 0.005, 0.0251),
}
# Section 4.4: the voltage 24 + 24 sin(16 pi t) [V], its frequency [Hz], and the measured time [s],
# of which figure 7 shows what comes after 0.15 s.
KAO_MEAN_VOLTAGE, KAO_AMPLITUDE, KAO_FREQUENCY = 24.0, 24.0, 8.0
KAO_DURATION, KAO_FIRST_TIME = 0.5, 0.15
