"""Run stored failures again: does each still fail, and how, or does the robot now arrive?"""
