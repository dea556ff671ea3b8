"""Datasets: thousands of rooms by one dataset.yaml, made by any number of processes.

``plan`` says what there is to do, as data: jobs, one for each room and variant, of units, one for
each view. ``executor`` is the contract of executors: ``local`` with processes of this machine,
``cluster`` with those of Ray. They run ``work``. It makes the room of a job (``variants``; of
captures, if they show enough of it), opens it once and finds its cameras (``shots``). It renders
its views, checks each (``quality``) and counts its pixels. ``store`` knows where everything lies
and lets it appear whole, with ``records`` of every file. Behind a URL (``remote``) a store is a
``scratch`` folder that puts there what is finished, by a lease.

``run`` is the course of a run, up to the report on all rooms, and ``outputs`` are their other forms
(``table`` is one). ``status`` and ``stats`` read the records again, and ``report`` makes a page of
them.
"""
