"""Films of recorded runs, and the viewer without a window that takes them."""

from lab.film.film_of_run import make_film
