"""What clean clips teach: sums and bounded samples of any number of clips, and what a recording needs of them."""
