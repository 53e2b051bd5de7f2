"""Which pixels are the person: the room, its furniture, who else is there."""
