// The functions of the C interface for recorded sessions.
#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine/bindings/c/call.h"
#include "engine/session/session_file.h"

namespace typodont::bindings {

struct SessionObject {
  std::unique_ptr<session::SessionReader> file;
  session::SessionReader& reader = *file;
  ~SessionObject() {
    const SessionFiles files;
    file.reset();
  }
};

namespace {

template <class Message, class Row>
void put_rows(const Message* messages, std::size_t count, Row* rows) {
  const std::uint32_t stride = rows->struct_size;
  for (std::size_t i = 0; i < count; ++i) {
    Row& row = element(rows, i, stride);
    row.struct_size = stride;
    put(messages[i], row);
  }
}

template <class Row>
void require_rows(const Row* rows, std::size_t count, const std::size_t* read) {
  require(read && (rows || count == 0), "NULL for the rows or for their count");
  require(count == 0 || sized(rows->struct_size, sizeof *rows), kBadSize);
}

}  // namespace

}  // namespace typodont::bindings

using namespace typodont;
using namespace typodont::bindings;

typodont_result typodont_session_open(const char* file, typodont_session** out) {
  return guarded([&] {
    require(file && out, "NULL for the file or for the place of the handle");
    const SessionFiles files;
    *out = make_handle<typodont_session>(
        std::unique_ptr<SessionObject>(new SessionObject{std::make_unique<session::SessionReader>(file)}));
  });
}

typodont_result typodont_session_free(typodont_session* session) {
  return free_handle(session);
}

typodont_result typodont_session_info_of(typodont_session* session, typodont_session_info* out) {
  return with(session, [&](SessionObject& s) {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    out->truncated = s.reader.truncated();
    out->ticks = s.reader.tick_count();
    out->cuts = s.reader.cuts().size();
    out->events = s.reader.events().size();
    out->rate = s.reader.header().servo_rate;
    put(s.reader.header().volumes_before, out->volumes_before);
    std::fill_n(out->volumes_after, TYPODONT_TISSUES, std::numeric_limits<double>::quiet_NaN());
    const auto& result = s.reader.result();
    if (result && result->has_volumes) put(result->volumes_after, out->volumes_after);
  });
}

typodont_result typodont_session_text(typodont_session* session, const char* what, const char** text) {
  return with(session, [&](SessionObject& s) {
    require(what && text, "NULL for the name of the text or for its place");
    const session::SessionHeader& h = s.reader.header();
    const std::pair<const char*, const std::string*> texts[] = {
        {"scene", &h.scene_json},       {"rig", &h.rig_json}, {"hand", &h.hand},
        {"trainee", &h.trainee},        {"model", &h.model},  {"date", &h.date},
        {"version", &h.program_version}};
    for (const auto& [name, value] : texts) {
      if (std::strcmp(name, what) != 0) continue;
      *text = value->c_str();
      return;
    }
    throw Error("", "", what, "scene, rig, hand, trainee, model, date or version");
  });
}

typodont_result typodont_session_ticks(typodont_session* session, uint64_t first, typodont_tick* ticks, size_t count,
                                       size_t* read) {
  return with(session, [&](SessionObject& s) {
    require_rows(ticks, count, read);
    const SessionFiles files;
    const std::vector<ServoTick> rows = s.reader.ticks(first, count);
    if (!rows.empty()) put_rows(rows.data(), rows.size(), ticks);
    *read = rows.size();
  });
}

typodont_result typodont_session_cuts(typodont_session* session, uint64_t first, typodont_cut* cuts, size_t count,
                                      size_t* read) {
  return with(session, [&](SessionObject& s) {
    require_rows(cuts, count, read);
    const std::vector<Cut>& all = s.reader.cuts();
    const std::size_t from = std::min<std::uint64_t>(first, all.size()), rows = std::min(count, all.size() - from);
    if (rows > 0) put_rows(all.data() + from, rows, cuts);
    *read = rows;
  });
}

typodont_result typodont_session_event(typodont_session* session, uint64_t place, typodont_event* out) {
  return with(session, [&](SessionObject& s) {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    const auto& events = s.reader.events();
    if (place >= events.size()) return fail(TYPODONT_END, "there are no more events");
    const session::SessionEvent& event = events[place];
    out->t_ns = event.t;
    out->kind = session::name_of(event.kind).data();
    out->text = event.text.c_str();
    return typodont_result{TYPODONT_OK};
  });
}
