"""Reported behaviours of real arms and hands."""

from extensions.emulators.common import reported

AS_REPORTED = reported("""
unhomed | the hand was not homed: it tells an opening of 0 and refuses to move | franka_ros #276
slow-homing | the hand was not homed, and homing takes 12 s | fairo #1356 (6.67 s)
move-blocks | blocked fingers go on until they are stopped | libfranka #18, franka_ros #281
stop-unheeded | the same, and no stop is answered before that motion has ended | libfranka #18, #28
move-fails | blocked fingers end with a failure | panda-py #12
second-grasp-fails | a grasp of what is held already takes 4 s and fails | libfranka #93
second-grasp-false | a grasp of what is held already is unsuccessful at once | libfranka #108
wide-grasp-fails | a grasp of what is nearly as wide as the hand fails | libfranka #202, franky #58
strict-grasp | a grasp outside of its tolerance lets go again | panda-py #50, franka_ros #16
never-grasped | the hand never says that it holds something | libfranka #13
slow-hand | the hand tells its state 10 times a second | franky #35, franka_ros #127
stop-needs-recovery | after its button it refuses all until recovered | franka_ros #308, #25, #279
needs-recovery | the same from the beginning: the button was pressed | franka_ros #308, #232
slow-recovery | a recovery takes 12 s | franka_ros #317 (0.4 to 16 s)
forgets-errors | once it rests it tells no more what it has stopped for | franka_ros #32
late-reflex | it tells of a reflex 1.5 s after it has stopped | franka_ros #317
velocity-violation | motions end slowly with joint_velocity_violation | franka_ros2 #70, #76
lost-bursts | every 2 s nothing arrives for 30 ms | libfranka #60, #163
slow-line | the line takes too long for every command | libfranka #174 (0.8 ms there and back)
udp-blocked | a firewall lets the connection through and no state | libfranka #165, #40, #203
wrong-version | an FR3, of interface version 10 | panda-py #41
locked | the joints are locked | libfranka #133
guided | a person has it by the hand | franky #17
user-stopped | its stop button is pressed, or a rule says so | libfranka #128
""")
"""Reported behaviours by name: of the hand, then of the arm."""
