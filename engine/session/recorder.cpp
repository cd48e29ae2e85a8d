#include "engine/session/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/base/error.h"
#include "engine/base/memory.h"
#include "engine/base/partial_file.h"
#include "engine/base/sync.h"
#include "engine/session/format/hdf5.h"
#include "engine/session/format/journal.h"
#include "engine/session/format/layout.h"
#include "engine/session/format/table.h"

namespace typodont::session {

namespace {

constexpr hsize_t kMaxChunkBytes = 1 << 16;  // largest size of a chunk in bytes, for all datasets

template <class Message>
std::vector<Table::Spec> specs_of(const std::vector<Column<Message>>& columns) {
  std::vector<Table::Spec> specs;
  for (const auto& column : columns) {
    if (!column.in_file) continue;
    std::string labels;
    if (column.name == "tissue") labels = tissue_labels();
    if (column.name == "faults") labels = fault_labels();
    specs.push_back({column.name, column.unit, column.text, labels, H5(H5Tcopy(h5_type(column.type)), H5Tclose),
                     size_of(column.type)});
  }
  return specs;
}

Table::Spec number(const char* name, const char* unit, const char* text, Type type, std::string labels = "") {
  return {name, unit, text, std::move(labels), H5(H5Tcopy(h5_type(type)), H5Tclose), size_of(type)};
}
Table::Spec fixed_text(const char* name, const char* text, std::size_t size) {
  return {name, "", text, "", h5_string_type(size), size};
}

bool plain_name(const std::string& name) {
  return !name.empty() && name.size() < 64 &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

/// The longest prefix of the text with at most `size` bytes. The prefix does not split a UTF-8 character.
std::string_view piece_of(std::string_view text, std::size_t size) {
  if (text.size() <= size) return text;
  std::size_t n = size;
  while (n > size - 4 && (static_cast<unsigned char>(text[n]) & 0xC0) == 0x80) --n;
  return text.substr(0, n);
}

// Bytes that must be free to create a file, and for a write: HDF5 can crash if memory runs out inside a call.
constexpr std::size_t kRoomToCreate = 32 << 20, kRoomToWrite = 4 << 20;

PerTissue in_mm3(const PerTissue& volumes) {
  PerTissue result = volumes;
  for (double& v : result) v *= 1e9;
  return result;
}

}  // namespace

struct SessionWriter::Impl {
  std::filesystem::path file, written_to;
  std::optional<PartialFile> partial;  // exists while the file has its temporary name `written_to`
  // exists only for live recordings; declared before h5, because it must exist longer than h5
  std::optional<Journal> journal;
  WriterOptions options;
  WriterStatus status;
  int lock_fd = -1;

  H5 h5;
  Table ticks, cuts, patches, events, pictures;
  std::vector<Table> streams;
  std::vector<H5> loop_datasets;  // in the order of LoopFields::each()
  std::optional<LoopReport> loop_unwritten;
  H5 lost, complete, volumes_after, volumes_ideal, pulp_distance, field_hash, png;
  hsize_t png_bytes = 0;
  std::uint64_t disk_lost_unreported = 0;
  Lost lost_in_file;
  Nanos last_write = now();
  Nanos last_t = 0;  // ns, time of the newest tick
  std::vector<std::string> tool_names;
  std::uint32_t last_tool = 0;

  ~Impl() { close(); }
  void create(const SessionHeader& header);
  void take_name();
  bool create_header(const SessionHeader& header);
  void note_tool(const ServoTick& tick);
  bool create_tables(const SessionHeader& header);
  bool create_result();
  bool create_loop();
  bool write_loop();
  bool write_lost();
  void write_all();
  bool write_table(Table& table, std::uint64_t& lost_rows);
  void count_commit() noexcept;
  std::string reason() const;
  std::optional<std::uint64_t> free_bytes() const noexcept;
  bool disk_has_room();
  void fail(const std::string& why);
  bool open() const {
    return status.state == WriterStatus::State::kRecording || status.state == WriterStatus::State::kDiskLow ||
           status.state == WriterStatus::State::kDiskFull;
  }
  bool close() noexcept;
  /// Ends the recording if the session file was removed, replaced by another file or shortened.
  void fail_if_gone();

  /// Counts the rows in the buffers as lost, so that there is room for the next ones.
  void drop_rows() noexcept {
    const auto drop = [](Table& table, std::uint64_t& lost_rows) { lost_rows += table.buffered(), table.drop(); };
    drop(ticks, status.lost.ticks_disk), drop(cuts, status.lost.cuts_disk);
    for (Table* table : {&patches, &events}) drop(*table, status.lost.other_disk);
    for (Table& stream : streams) drop(stream, status.lost.other_disk);
    drop(pictures, status.lost.pictures_disk);
  }

  template <class Message>
  void add(Table& table, const std::vector<Column<Message>>& columns, const Message& message) {
    std::size_t i = 0;
    for (const auto& column : columns) {
      if (column.in_file) column.get(message, table.cell(i++));
    }
    table.end_row();
  }
  template <class Message>
  void append(Table& table, const std::vector<Column<Message>>& columns, std::span<const Message> messages,
              std::uint64_t& lost_rows) noexcept {
    guarded([&] {
      for (const Message& message : messages) {
        add(table, columns, message);
        if (table.full()) write_table(table, lost_rows);
      }
    });
  }
  void add_event(const SessionEvent& event);
  bool finish(const SessionResult& result);

  /// Runs a part of the recorder's work. If it throws (out of memory), the recording ends and the session continues.
  template <class Work>
  void guarded(const Work& work) noexcept {
    const H5Quiet quiet;
    try {
      work();
    } catch (const std::exception& e) {
      status.state = WriterStatus::State::kFailed;
      drop_rows();
      try {
        status.message = fmt::format("{}: {}; the session goes on, unrecorded", written_to.string(), e.what());
      } catch (const std::bad_alloc&) {
      }
    }
  }
};

void SessionWriter::Impl::create(const SessionHeader& header) {
  const H5Quiet quiet;
  const auto refuse = [&](const std::string& why) {
    throw Error(file.string(), "", why, "a place where a session can be recorded");
  };
  tool_names = header.tools;
  for (const StreamSpec& stream : header.streams) {
    bool good = plain_name(stream.name) && !stream.columns.empty();
    for (const auto& column : stream.columns) good = good && plain_name(column.name) && column.name != "t_ns";
    if (!good) throw Error(file.string(), "stream " + stream.name, "an impossible name", "letters, digits and _");
  }
  written_to = partial.emplace(file, FileKind::kSession).path();
  if (!partial->makes_file() && !options.whole_or_nothing) refuse("a device or a FIFO");
  if (partial->makes_file() && is_being_recorded(file)) refuse("a session that is being recorded");
  if (const auto free = free_bytes(); free && *free < options.disk_needed)
    refuse(fmt::format("a disk with {} MB left, of {} MB that a recording needs to begin", *free >> 20,
                       options.disk_needed >> 20));

  require_memory(kRoomToCreate);
  H5 access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // SWMR (single writer, multiple readers) needs this file format version
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  if (!options.whole_or_nothing && !options.rewrites && !journal.emplace(file).use(access.get())) refuse(h5_reason());
  // Sets a small cache for every dataset. Rows are written in order, so a column's cache must only contain the current
  // chunk; HDF5's default of 1 MB per column would waste 50 MB. The size is set for the whole file, because SWMR mode
  // opens the datasets again without their own settings.
  H5Pset_cache(access.get(), 0, 11, kMaxChunkBytes, 1.0);
  const H5 creation = without_times(H5P_FILE_CREATE);
  errno = 0;
  h5 = H5(H5Fcreate(written_to.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
  if (!h5) refuse(errno ? std::strerror(errno) : h5_reason());
  // While SWMR starts, no handles of groups or attributes may be open. Handles of datasets may be open.
  if (!create_header(header) || !create_tables(header) || !create_result() || !create_loop() ||
      H5Fflush(h5.get(), H5F_SCOPE_GLOBAL) < 0 || H5Fstart_swmr_write(h5.get()) < 0) {
    refuse(h5_reason());
  }
  lock_fd = lock_while_recording(written_to);
  if (!options.whole_or_nothing && !options.named_by_start) take_name();
}

/// Gives the file its final name. From here on, it can be opened even if the program is killed.
void SessionWriter::Impl::take_name() {
  if (journal) journal->start();
  partial->keep();
  partial.reset();
  written_to = file;
}

void SessionWriter::Impl::note_tool(const ServoTick& tick) {
  last_tool = tick.tool;
  const H5Quiet quiet;
  add_event(
      {tick.t, EventKind::kTool, tick.tool < tool_names.size() ? tool_names[tick.tool] : std::to_string(tick.tool)});
}

void SessionWriter::Impl::fail_if_gone() {
  struct stat written {
  }, named{};
  if (!open() || partial || lock_fd < 0 || ::fstat(lock_fd, &written) != 0) return;
  if (::stat(written_to.c_str(), &named) != 0 || named.st_ino != written.st_ino || named.st_dev != written.st_dev)
    fail("it was deleted or replaced while it was recorded");
  else if (journal && static_cast<std::uint64_t>(written.st_size) < journal->length())
    fail("it was shortened by another program while it was recorded");
}

bool SessionWriter::Impl::create_header(const SessionHeader& header) {
  const hid_t root = h5.get();
  const H5 group = create_group(root, "header");
  if (!group) return false;
  nlohmann::json files = nlohmann::json::array(), seeds = nlohmann::json::array(),
                 streams_json = nlohmann::json::array();
  for (const SourceFile& f : header.files) files.push_back({{"path", f.path}, {"bytes", f.bytes}, {"hash", f.hash}});
  // Seeds are written as text, because some JSON readers cannot represent 64-bit numbers.
  for (const auto& [name, seed] : header.seeds) seeds.push_back({{"name", name}, {"seed", std::to_string(seed)}});
  for (const StreamSpec& s : header.streams) {
    nlohmann::json columns = nlohmann::json::array();
    for (const auto& c : s.columns) columns.push_back({{"name", c.name}, {"unit", c.unit}});
    streams_json.push_back({{"name", s.name}, {"columns", columns}});
  }
  const auto dump = [](const nlohmann::json& j) {
    return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  bool good =
      (!journal || set_attribute(root, "recording", journal->recording())) &&
      set_attribute(root, "format", kFormatName) &&
      set_attribute(root, "format_version", std::uint64_t{kFormatVersion}) &&
      set_attribute(root, "program_version", header.program_version) &&
      set_attribute(root, "compiler", header.compiler) && set_attribute(root, "date", header.date) &&
      set_attribute(root, "hand", header.hand) && set_attribute(root, "trainee", header.trainee) &&
      set_attribute(root, "warnings", dump(header.warnings)) && set_attribute(root, "model", header.model) &&
      set_attribute(root, "force_law", header.force_law) && set_attribute(root, "servo_rate_Hz", header.servo_rate) &&
      set_attribute(root, "vibration_band_Hz", header.vibration_band) &&
      set_attribute(root, "position_step_m", header.position_step) &&  // the value is stored with all bits
      set_attribute(root, "gives_torque", std::uint64_t{header.gives_torque}) &&
      set_attribute(root, "voxel_mm", header.voxel * 1e3) && write_text(group.get(), "scene", header.scene_json) &&
      write_text(group.get(), "rig", header.rig_json) && write_text(group.get(), "files", dump(files)) &&
      write_text(group.get(), "seeds", dump(seeds)) && write_text(group.get(), "tools", dump(header.tools)) &&
      write_text(group.get(), "streams", dump(streams_json));
  if (!good) return false;
  const PerTissue before = in_mm3(header.volumes_before);
  H5 dataset;
  return create_numbers(group.get(), "volumes_before_mm3", "mm^3", "volume of each tissue at the start",
                        H5T_NATIVE_DOUBLE, kTissueCount, before.data(), dataset, tissue_labels());
}

bool SessionWriter::Impl::create_tables(const SessionHeader& header) {
  // A chunk should become full shortly before a flush is due, so that each chunk is written only once. Its size is this
  // fraction of the rows that arrive in a flush interval at the servo's nominal rate. With 0.9, a servo at nine tenths
  // of this rate still fills the chunk in time.
  constexpr double kOfAFlush = 0.9;
  const double rows = std::clamp(header.servo_rate * to_seconds(options.flush_interval) * kOfAFlush, 256.0, 8192.0);
  const auto tick_chunk = static_cast<std::size_t>(rows);
  constexpr std::size_t kSmallChunk = 128, kEventChunk = 16;
  const int deflate = std::clamp(options.deflate, 1, 9);
  const hid_t root = h5.get();

  std::vector<Table::Spec> event_specs;
  event_specs.push_back(number("t_ns", "ns", "when, since the session's start", Type::kI64));
  event_specs.push_back(number("kind", "", "what kind of event", Type::kU8, event_labels()));
  event_specs.push_back(number("part", "", "0: a new event; 1, 2 ...: its text goes on", Type::kU32));
  event_specs.push_back(fixed_text("text", "UTF-8, free or JSON", kEventText));

  std::vector<Table::Spec> picture_specs;
  picture_specs.push_back(fixed_text("name", "before, after, ...", kPictureText));
  picture_specs.push_back(fixed_text("title", "for people", kPictureText));
  picture_specs.push_back(number("offset", "", "where its PNG begins in /pictures/png", Type::kU64));
  picture_specs.push_back(number("bytes", "", "length of its PNG", Type::kU64));

  bool good =
      ticks.create(root, "ticks", "one row per tick of the servo", specs_of(tick_columns()), tick_chunk, deflate) &&
      cuts.create(root, "cuts", "one row per cut, straight from A to B", specs_of(cut_columns()), kSmallChunk,
                  deflate) &&
      patches.create(root, "patches", "when the servo took up which tissue patch", specs_of(patch_columns()),
                     kSmallChunk, deflate) &&
      events.create(root, "events", "tools, views, faults, notes", std::move(event_specs), kEventChunk, deflate) &&
      pictures.create(root, "pictures", "pictures for the report", std::move(picture_specs), 8, deflate);
  if (!good) return false;

  const H5 group = create_group(root, "streams");
  streams.resize(header.streams.size());
  for (std::size_t i = 0; i < streams.size(); ++i) {
    std::vector<Table::Spec> specs;
    specs.push_back(number("t_ns", "ns", "when, since the session's start", Type::kI64));
    for (const auto& c : header.streams[i].columns)
      specs.push_back(number(c.name.c_str(), c.unit.c_str(), "", Type::kF64));
    if (!streams[i].create(root, "streams/" + header.streams[i].name, "samples of " + header.streams[i].name,
                           std::move(specs), kSmallChunk, deflate)) {
      return false;
    }
  }

  const hsize_t zero = 0, unlimited = H5S_UNLIMITED, chunk = kMaxChunkBytes;
  const H5 properties = without_times(H5P_DATASET_CREATE);
  H5Pset_chunk(properties.get(), 1, &chunk);
  H5Pset_fletcher32(properties.get());
  H5 space(H5Screate_simple(1, &zero, &unlimited), H5Sclose);
  png = H5(H5Dcreate2(root, "pictures/png", H5T_NATIVE_UINT8, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
           H5Dclose);
  return static_cast<bool>(png);
}

bool SessionWriter::Impl::create_result() {
  const H5 group = create_group(h5.get(), "result");
  PerTissue unknown;
  unknown.fill(std::numeric_limits<double>::quiet_NaN());
  const std::uint64_t zero = 0;
  status.lost = lost_in_file = options.lost_before;
  const auto losses = as_array(lost_in_file);
  return group &&
         create_numbers(group.get(), "volumes_after_mm3", "mm^3", "volume of each tissue at the end; NaN: not known",
                        H5T_NATIVE_DOUBLE, kTissueCount, unknown.data(), volumes_after, tissue_labels()) &&
         create_numbers(group.get(), "volumes_ideal_mm3", "mm^3",
                        "volume of each tissue in the ideal result; NaN: none", H5T_NATIVE_DOUBLE, kTissueCount,
                        unknown.data(), volumes_ideal, tissue_labels()) &&
         create_numbers(group.get(), "min_pulp_distance_mm", "mm",
                        "from the cut surface to the pulp; NaN: not measured", H5T_NATIVE_DOUBLE, 0, unknown.data(),
                        pulp_distance) &&
         create_numbers(group.get(), "field_hash", "", "of the tissue at the end; 0: not taken", H5T_NATIVE_UINT64, 0,
                        &zero, field_hash) &&
         create_numbers(h5.get(), "lost", "", "what did not reach the file", H5T_NATIVE_UINT64, losses.size(),
                        losses.data(), lost, kLostLabels) &&
         create_numbers(h5.get(), "complete", "", "1: the recording was finished; 0: it was cut off", H5T_NATIVE_UINT64,
                        0, &zero, complete);
}

bool SessionWriter::Impl::create_loop() {
  const H5 group = create_group(h5.get(), "loop");
  LoopFields zero(LoopReport{});
  return group && set_attribute(group.get(), "description", "how the servo kept its time, and what it was granted") &&
         zero.each([&](const char* name, Type type, const char* text, const std::string& labels, const auto& numbers) {
           return create_numbers(group.get(), name, "", text, h5_type(type), numbers.size(), numbers.data(),
                                 loop_datasets.emplace_back(), labels);
         });
}

bool SessionWriter::Impl::write_loop() {
  LoopFields fields(*loop_unwritten);
  loop_unwritten.reset();
  auto dataset = loop_datasets.begin();
  return fields.each([&](const char*, Type type, const char*, const std::string&, const auto& numbers) {
    return overwrite(*dataset++, h5_type(type), numbers.data());
  });
}

bool SessionWriter::Impl::write_lost() {
  if (status.lost == lost_in_file) return true;
  lost_in_file = status.lost;
  return overwrite(lost, H5T_NATIVE_UINT64, as_array(lost_in_file).data());
}

void SessionWriter::Impl::fail(const std::string& why) {
  if (status.state == WriterStatus::State::kFailed) return;
  status.state = WriterStatus::State::kFailed;
  status.message = fmt::format("{}: {}; the session goes on, unrecorded", written_to.string(), why);
}

std::optional<std::uint64_t> SessionWriter::Impl::free_bytes() const noexcept {
  if (options.free_bytes) return options.free_bytes();
  struct statvfs space {};
  // If the free space is unknown, the recording continues until a write fails.
  if (statvfs(written_to.c_str(), &space) != 0) return std::nullopt;
  return std::uint64_t{space.f_bavail} * space.f_frsize;
}

bool SessionWriter::Impl::disk_has_room() {
  const std::uint64_t free = free_bytes().value_or(UINT64_MAX);
  if (free >= options.disk_reserve) {
    status.state = free < options.disk_low ? WriterStatus::State::kDiskLow : WriterStatus::State::kRecording;
    if (free < options.disk_low)
      status.message = fmt::format("{}: only {} MB are left on the disk; the recording will soon have gaps",
                                   written_to.string(), free >> 20);
    return true;
  }
  status.state = WriterStatus::State::kDiskFull;
  status.message =
      fmt::format("{}: only {} MB are left on the disk; the session goes on, and what is not recorded is counted",
                  written_to.string(), free >> 20);
  return false;
}

/// Writes the buffered rows of a table. If this fails, the rows are counted as lost.
bool SessionWriter::Impl::write_table(Table& table, std::uint64_t& lost_rows) {
  if (open() && disk_has_room()) {
    require_memory(kRoomToWrite);
    errno = 0;
    if (table.write()) return true;
    fail(reason());
  }
  lost_rows += table.buffered();
  disk_lost_unreported += table.buffered();
  table.drop();
  return false;
}

/// Writes all buffered rows. Cuts and uses of tissue patches come first, so that the file never contains a tick without
/// its cut.
void SessionWriter::Impl::write_all() {
  const H5Quiet quiet;
  const Nanos begin = now();
  fail_if_gone();
  if (disk_lost_unreported > 0 && open() && disk_has_room()) {
    SessionEvent gap;
    gap.t = last_t;
    gap.kind = EventKind::kFault;
    gap.text = fmt::format("{{\"fault\": \"disk_full\", \"rows_lost\": {}}}", disk_lost_unreported);
    disk_lost_unreported = 0;
    add_event(gap);
  }
  Lost& l = status.lost;
  write_table(patches, l.other_disk);
  write_table(cuts, l.cuts_disk);
  write_table(events, l.other_disk);
  for (Table& stream : streams) write_table(stream, l.other_disk);
  write_table(ticks, l.ticks_disk);
  // Flushes the file only if the disk has free space. On a full disk, the flush would fail and end the recording. If
  // the flush is skipped, the next flush with free space writes the data.
  if (open() && disk_has_room()) {
    bool good = write_lost();
    if (good && loop_unwritten) good = write_loop();
    errno = 0;
    if (!good || H5Fflush(h5.get(), H5F_SCOPE_GLOBAL) < 0) fail(reason());
  }
  count_commit();
  // The next flush interval begins at the time when this write began. If it began at the end of the write, a slow disk
  // would make the intervals longer.
  last_write = begin;
  status.slowest_flush = std::max(status.slowest_flush, now() - begin);
}

/// Counts rows as lost that HDF5 accepted but that did not reach the disk.
void SessionWriter::Impl::count_commit() noexcept {
  const bool safe = open();
  const auto settle = [&](Table& table, std::uint64_t& lost_rows) {
    if (!safe) lost_rows += table.uncommitted();
    const std::uint64_t kept = table.written() - (safe ? 0 : table.uncommitted());
    table.commit();
    return kept;
  };
  const std::uint64_t ticks_before = status.ticks, cuts_before = status.cuts;
  Lost& l = status.lost;
  settle(patches, l.other_disk);
  settle(events, l.other_disk);
  for (Table& stream : streams) settle(stream, l.other_disk);
  const std::uint64_t cuts_now = settle(cuts, l.cuts_disk), ticks_now = settle(ticks, l.ticks_disk);
  status.ticks = safe ? ticks_now : ticks_before;
  status.cuts = safe ? cuts_now : cuts_before;
}

std::string SessionWriter::Impl::reason() const {
  if (journal && !journal->failure().empty()) return journal->failure();
  return errno ? std::strerror(errno) : h5_reason();
}

void SessionWriter::Impl::add_event(const SessionEvent& event) {
  std::string_view rest = event.text;
  std::uint32_t part = 0;
  do {
    const std::string_view piece = piece_of(rest, kEventText);
    events.put(0, event.t);
    events.put(1, event.kind);
    events.put(2, part);
    events.put(3, piece);
    events.end_row();
    if (events.full()) write_table(events, status.lost.other_disk);
    rest.remove_prefix(piece.size());
    ++part;
  } while (!rest.empty());
}

bool SessionWriter::Impl::close() noexcept {
  const H5Quiet quiet;
  ticks.close();
  cuts.close();
  patches.close();
  events.close();
  pictures.close();
  for (Table& stream : streams) stream.close();
  loop_datasets.clear();
  for (H5* dataset : {&lost, &complete, &volumes_after, &volumes_ideal, &pulp_distance, &field_hash, &png})
    dataset->reset();
  errno = 0;
  const bool good = h5.reset();
  if (!good) guarded([&] { fail(reason()); });
  if (lock_fd >= 0) ::close(lock_fd);
  lock_fd = -1;
  return good;
}

SessionWriter::SessionWriter(const std::filesystem::path& file, const SessionHeader& header,
                             const WriterOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->options = options;
  impl_->create(header);
}

SessionWriter::~SessionWriter() {
  if (impl_->status.state == WriterStatus::State::kFinished) return;
  impl_->guarded([&] { impl_->write_all(); });
}

void SessionWriter::start() {
  if (impl_->options.named_by_start) impl_->take_name();
}

void SessionWriter::append(std::span<const ServoTick> ticks) noexcept {
  impl_->guarded([&] {
    for (const ServoTick& tick : ticks) {
      impl_->add(impl_->ticks, tick_columns(), tick);
      impl_->last_t = tick.t;
      if (tick.tool != impl_->last_tool && !impl_->options.rewrites) impl_->note_tool(tick);
      if (impl_->ticks.full()) impl_->write_all();
    }
  });
}

void SessionWriter::append(std::span<const Cut> cuts) noexcept {
  impl_->append(impl_->cuts, cut_columns(), cuts, impl_->status.lost.cuts_disk);
}

void SessionWriter::append(std::span<const PatchUse> patches) noexcept {
  impl_->append(impl_->patches, patch_columns(), patches, impl_->status.lost.other_disk);
}

void SessionWriter::append(const SessionEvent& event) noexcept {
  impl_->guarded([&] { impl_->add_event(event); });
}

void SessionWriter::event(Nanos t, EventKind kind, std::string_view text) noexcept {
  impl_->guarded([&] { impl_->add_event({t, kind, std::string(text)}); });
}

void SessionWriter::loop(const LoopReport& report) noexcept {
  impl_->loop_unwritten = report;
}

void SessionWriter::append(std::size_t stream, Nanos t, std::span<const double> values) noexcept {
  impl_->guarded([&] {
    Table& table = impl_->streams[stream];
    table.put(0, t);
    for (std::size_t i = 0; i < values.size(); ++i) table.put(i + 1, values[i]);
    table.end_row();
    if (table.full()) impl_->write_table(table, impl_->status.lost.other_disk);
  });
}

void SessionWriter::count_ring_losses(std::uint64_t ticks, std::uint64_t cuts, std::uint64_t other) noexcept {
  const Lost& before = impl_->options.lost_before;
  Lost& lost = impl_->status.lost;
  lost.ticks_ring = before.ticks_ring + ticks;
  lost.cuts_ring = before.cuts_ring + cuts;
  lost.other_ring = before.other_ring + other;
}

void SessionWriter::heartbeat() noexcept {
  if (now() - impl_->last_write >= impl_->options.flush_interval) flush();
}

void SessionWriter::flush() noexcept {
  impl_->guarded([&] { impl_->write_all(); });
}

bool SessionWriter::finish(const SessionResult& result) noexcept {
  bool whole = false;
  impl_->guarded([&] { whole = impl_->finish(result); });
  return whole;
}

bool SessionWriter::Impl::finish(const SessionResult& result) {
  if (status.state == WriterStatus::State::kFinished) return !status.lost.any();
  write_all();
  if (open()) {
    bool good = true;
    if (result.has_volumes) good = overwrite(volumes_after, H5T_NATIVE_DOUBLE, in_mm3(result.volumes_after).data());
    if (result.has_ideal) {
      good = good && overwrite(volumes_ideal, H5T_NATIVE_DOUBLE, in_mm3(result.volumes_ideal).data());
    }
    if (result.min_pulp_distance >= 0) {
      const double mm = result.min_pulp_distance * 1e3;
      good = good && overwrite(pulp_distance, H5T_NATIVE_DOUBLE, &mm);
    }
    good = good && overwrite(field_hash, H5T_NATIVE_UINT64, &result.field_hash);
    for (const SessionPicture& picture : result.pictures) {
      if (!disk_has_room()) {
        ++status.lost.pictures_disk;
        continue;
      }
      const hsize_t count = picture.png.size(), end = png_bytes + count;
      good = good && H5Dset_extent(png.get(), &end) >= 0;
      if (count > 0 && good) {
        H5 memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
        H5 space(H5Dget_space(png.get()), H5Sclose);
        good = H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &png_bytes, nullptr, &count, nullptr) >= 0 &&
               H5Dwrite(png.get(), H5T_NATIVE_UINT8, memory.get(), space.get(), H5P_DEFAULT, picture.png.data()) >= 0;
      }
      pictures.put(0, piece_of(picture.name, kPictureText));
      pictures.put(1, piece_of(picture.title, kPictureText));
      pictures.put(2, std::uint64_t{png_bytes});
      pictures.put(3, std::uint64_t{count});
      pictures.end_row();
      if (pictures.full()) write_table(pictures, status.lost.pictures_disk);
      png_bytes = end;
      good = good && H5Fflush(h5.get(), H5F_SCOPE_GLOBAL) >= 0;  // per picture, because the journal's size is limited
    }
    write_table(pictures, status.lost.pictures_disk);
    good = write_lost() && good;
    // The attribute "complete" is written last, when the file contains all other data.
    const std::uint64_t one = 1;
    errno = 0;
    if (!good || H5Fflush(h5.get(), H5F_SCOPE_GLOBAL) < 0 || !overwrite(complete, H5T_NATIVE_UINT64, &one)) {
      fail(reason());
    }
  }
  fail_if_gone();
  bool whole = open() && close();
  if (whole && partial) {
    try {
      partial->keep();
    } catch (const Error& error) {
      fail(error.what());
      whole = false;
    }
  }
  if (!whole) {
    close();
    partial.reset();
    return false;
  }
  status.state = WriterStatus::State::kFinished;
  if (!status.lost.any()) return true;
  status.message = fmt::format("{}: the recording lacks {}", file.string(), in_words(status.lost));
  return false;
}

const WriterStatus& SessionWriter::status() const noexcept {
  return impl_->status;
}

}  // namespace typodont::session
