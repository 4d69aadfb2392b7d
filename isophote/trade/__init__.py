"""The trade report: what each setting of a render buys in time and noise, and what it costs in truth.

Data flows one way, a noun a file:

    grid (settings to try) -> plan (how much of each fits the time) -> runs (pictures on disk)
        -> analysis (bias and noise with intervals) -> advice -> page (words, plots, pictures)

`report.make_report` does it in order; `isophote trade` and Blender's button call that. Nothing here needs Blender,
and nothing but numpy: the report is also made inside Blender's own Python.
"""
