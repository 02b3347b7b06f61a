"""What existed before a run is not searched for garbage during it."""

import gc

from app.core.memory import settled_memory


def test_what_exists_is_not_searched_until_the_end():
    with settled_memory():
        assert gc.get_freeze_count() > 0
        assert gc.isenabled()
    assert gc.get_freeze_count() == 0
