// Acts like a file manager when files are dragged onto another program's window: the XDND protocol, version 5.
#pragma once

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

namespace typodont::test {

/// Drops the files on the window. False if it does not accept them within ten seconds.
inline bool drop_on(Window target, const std::vector<std::string>& files) {
  Display* const display = XOpenDisplay(nullptr);
  if (!display) return false;
  const Window source = XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
  const auto atom = [&](const char* name) { return XInternAtom(display, name, False); };
  const Atom selection = atom("XdndSelection"), list = atom("text/uri-list");
  XSetSelectionOwner(display, selection, source, CurrentTime);
  std::string uris;
  for (const std::string& file : files) {
    uris += "file://";
    for (const char c : file) {
      const auto u = static_cast<unsigned char>(c);
      uris += std::isalnum(u) || c == '/' || c == '.' || c == '_' ? std::string(1, c) : fmt::format("%{:02X}", u);
    }
    uris += "\r\n";
  }
  const auto send = [&](const char* type, long a, long b, long c, long d) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target;
    event.xclient.message_type = atom(type);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(source);
    event.xclient.data.l[1] = a, event.xclient.data.l[2] = b;
    event.xclient.data.l[3] = c, event.xclient.data.l[4] = d;
    XSendEvent(display, target, False, NoEventMask, &event);
    XFlush(display);
  };
  constexpr long kVersion = 5, kPlace = 200L << 16 | 200;
  send("XdndEnter", kVersion << 24, static_cast<long>(list), 0, 0);
  send("XdndPosition", 0, kPlace, CurrentTime, static_cast<long>(atom("XdndActionCopy")));
  bool finished = false;
  for (int i = 0; i < 1000 && !finished; ++i) {
    if (!XPending(display)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      continue;
    }
    XEvent event;
    XNextEvent(display, &event);
    if (event.type == SelectionRequest) {
      const XSelectionRequestEvent& asked = event.xselectionrequest;
      XChangeProperty(display, asked.requestor, asked.property, asked.target, 8, PropModeReplace,
                      reinterpret_cast<const unsigned char*>(uris.data()), static_cast<int>(uris.size()));
      XEvent answer{};
      answer.xselection.type = SelectionNotify;
      answer.xselection.requestor = asked.requestor;
      answer.xselection.selection = asked.selection;
      answer.xselection.target = asked.target;
      answer.xselection.property = asked.property;
      answer.xselection.time = asked.time;
      XSendEvent(display, asked.requestor, False, NoEventMask, &answer);
      XFlush(display);
    } else if (event.type == ClientMessage && event.xclient.message_type == atom("XdndStatus")) {
      send("XdndDrop", 0, CurrentTime, 0, 0);
    } else if (event.type == ClientMessage && event.xclient.message_type == atom("XdndFinished")) {
      finished = true;
    }
  }
  XDestroyWindow(display, source);
  XCloseDisplay(display);
  return finished;
}

}  // namespace typodont::test
