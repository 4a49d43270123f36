"""The MovingAI benchmark's problems, solved on its maps as we read them."""
