"""A form on top of a fit: what it is without its onset."""

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.forms.catalogue import forms, from_an_onset
from stillarm.diagnosis.search.begun import Begun, ground_of
from stillarm.diagnosis.search.refits import candidate_of, throughout
from tests.fixtures.synthetic import fitted, measured

SECONDS = 12.0
LAG = "drive.lag_speeding_up_s"


@pytest.mark.slow
@pytest.mark.parametrize(("acts_from_s", "with_onset"), [(0.0, False), (6.0, True)])
def test_a_form_has_an_onset_where_it_gains_by_it(acts_from_s: float, with_onset: bool) -> None:
    """The first move begins at 0.8 s: from when on a cause acts before that shows nowhere."""
    last = fitted(measured(SECONDS, 3, {LAG: 0.03, "drive.begin_s": acts_from_s}))
    split, world = interleaved(SECONDS), last.world
    (form,) = (one for one in forms(world) if one.name == "while it speeds up")
    later = from_an_onset(form)
    assert later is not None and later.throughout is form and later.begins == "drive.begin_s"
    begins_s = max(acts_from_s, 0.5)
    start = world.space.with_values(last.vector, {LAG: 0.02, later.begins: begins_s})
    begun, data = Begun(later, world, start), make_data(world, split)
    ended = fit(data, start, (*last.free, LAG), colour=last.colour)
    ground = ground_of(last, split)
    plain, whole = throughout(ground, (begun, ended))
    assert plain.form is form and whole.value(later.begins) == 0.0
    merit = {
        one.form.begins: candidate_of(ground, (one, one_fit)).merit
        for one, one_fit in ((begun, ended), (plain, whole))
    }
    assert (merit[later.begins] > merit[None]) == with_onset
    assert np.isclose(ended.value(LAG), 0.03, rtol=0.1)
