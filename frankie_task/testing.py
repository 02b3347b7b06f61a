"""What the tests of a behaviour need: a robot, a scene and a clock.

```python
def test_it_waves():
    with trial("single", seed=1) as t:
        assert t.run(Wave("wave", t.context, times=1)) is Status.SUCCESS
```
"""

from app.core import BrokenTrialError, Trial, trial

__all__ = ["BrokenTrialError", "Trial", "trial"]
