"""Tables, figures and reports that several commands share."""
