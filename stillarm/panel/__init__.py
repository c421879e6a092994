"""`stillarm panel`: a page in the browser that shows the running loop and recordings, and sends an operator's commands.

`server/` answers requests and refuses foreign ones; `live/` turns telemetry into what a page draws; `operate/` says
what is allowed and signs it; `recordings/` reads files and runs replay and diagnosis in processes of their own; `page/`
is what the browser loads. The panel listens and is never asked by the loop. Begin with `panel.py`.
"""

__all__ = ["answer", "panel"]
