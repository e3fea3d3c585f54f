"""The paper, reproduced: Table 1, Figure 6 and Figure 7 on any character, our methods beside its own."""
