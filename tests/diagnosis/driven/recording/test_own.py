"""Names of numbers that one of several recordings has for itself."""

from stillarm.diagnosis.driven.recording.own import base_of, named_in, numbers_in, recording_of, with_own


def test_a_recordings_own_number_goes_before_the_common_one() -> None:
    numbers = {"coulomb": 1.0, "gain": 3.0, named_in("coulomb", 1): 2.0, named_in("offset a b", 2): 4.0}
    assert numbers_in(numbers, 0) == {"coulomb": 1.0, "gain": 3.0}
    assert numbers_in(numbers, 1) == {"coulomb": 2.0, "gain": 3.0}
    assert numbers_in(numbers, 2) == {"coulomb": 1.0, "gain": 3.0, "offset a b": 4.0}


def test_a_name_says_whose_it_is() -> None:
    for name in ("coulomb", "offset joint_position_rad"):
        assert base_of(name) == name and recording_of(name) is None
        assert base_of(named_in(name, 12)) == name and recording_of(named_in(name, 12)) == 12


def test_an_own_number_begins_at_the_common_one_and_keeps_what_it_has() -> None:
    free = ("gain", named_in("gain", 1), named_in("coulomb", 2))
    begun = with_own({"gain": 3.0, named_in("coulomb", 2): 5.0}, free)
    assert begun == {"gain": 3.0, named_in("gain", 1): 3.0, named_in("coulomb", 2): 5.0}
