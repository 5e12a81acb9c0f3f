"""Decisions: the numbers by which something is told, claimed or refused everywhere alike, each once, with its reason.

Numbers of one search or one picture stand beside its own code.
"""

import numpy as np

FALSE_ALARM = 1e-4  # that chance alone does it, over all names together: some ten questions of a case stay below 0.1 %
LOST_BY_CHANCE = 1e-6  # the same of missing values, of which tiles of one material decide together
REPLICATED = 0.4  # of a gain, that recordings or frames which took no part in the fit must show: half, less their noise
SURE = 10.0  # chi2 by which one explanation must be likelier than another: chance has it in one case of some hundreds
# score that it costs: a wrong size of what the model holds, or a bound that a law depends on, needs none
SECOND_CAUSE = 8.0
TYPICAL = float(np.log(3.0))  # an effect that is there has its typical size to this factor (one standard deviation)
DETECTED = 5.0  # standard deviations from which on an effect can be told
ALIKE = 0.95  # cosine of two footprints from which on these data do not tell them apart
LARGEST_SET = 3  # names that a claim may have: more of them name nothing
CONFIDENCE = 0.95  # of a limit, and the posterior from which on a claim is established
NOTICED = 4.0  # drop of a chi2: two standard deviations of one number, less contradicts nothing
FAR = 4.0  # standard deviations from which on a tile counts less
FEWEST = 5  # recordings from which on one can be told from the others
NOISE_ALONE = 1.3  # chi2 per tile up to which a recording shows noise and nothing else (guess)
SPREAD_FRAMES = 4  # frames from which on a spread can be told: a variance from fewer says little
