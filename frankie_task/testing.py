"""What the tests of a behaviour or a driver need: a robot, a scene and a clock; the contract.

```python
def test_it_waves():
    with trial("single", seed=1) as t:
        assert t.run(Wave("wave", t.context, times=1)) is Status.SUCCESS

def test_the_arm():
    with our_simulator() as address:
        check_driver("arm", lambda context: OurArm(Options(address=address), context))
```
"""

from frankie_task.contract import BrokenContractError, check_driver
from frankie_task.trial import BrokenTrialError, Trial, trial

__all__ = ["BrokenContractError", "BrokenTrialError", "Trial", "check_driver", "trial"]
