"""The filters and gap fillers that a user can choose instead, and what they give back."""
