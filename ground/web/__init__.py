# SPDX-License-Identifier: GPL-3.0-or-later
"""The page: a Starlette server on 127.0.0.1, and static files that browsers run.

access    who may talk to the server     cockpit   what pages may do to one drone
server    addresses and sockets          hand      flying it by hand
page      one page at its socket         fleet     all drones of a station
flow      how much one page may send     insight   what the drone would decide, by its own C code
wishes    from a page's JSON to calls    people    who moves about
frames, status, events, parameters, overlays: what a page is sent
"""
