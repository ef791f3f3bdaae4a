"""The paper itself: its printed numbers, its designs, its experiment and the scoreboard."""
