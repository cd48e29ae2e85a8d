#include "engine/session/session_file.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"
#include "engine/base/partial_file.h"
#include "engine/base/sync.h"
#include "engine/session/format/checks.h"
#include "engine/session/format/file_bytes.h"
#include "engine/session/format/hdf5.h"
#include "engine/session/format/journal.h"
#include "engine/session/format/layout.h"
#include "engine/session/recorder.h"
#include "engine/session/signature.h"

namespace typodont::session {

namespace {

struct ColumnName {
  std::string name;
  bool may_lack = false;  // true: files of older versions do not have this column
};

/// Reads one table of the file. Only rows that are not damaged can be read.
class TableReader {
 public:
  /// Opens the table. If `salvage` is true (the file was cut off), the readable length of every column is determined.
  void open(const std::filesystem::path& file, hid_t root, const std::string& path,
            const std::vector<ColumnName>& names, bool salvage) {
    file_ = file.string();
    path_ = path;
    if (!open_group(file_, root, path)) throw Error(file_, path, "nothing", "this group");
    hsize_t fewest = H5S_UNLIMITED, most = 0;
    for (const auto& [name, may_lack] : names) {
      H5 dataset = open_dataset(file_, root, path + "/" + name);
      if (!dataset && may_lack) {
        datasets_.emplace_back();
        continue;
      }
      if (!dataset) throw Error(file_, path + "/" + name, "nothing", "this column");
      H5 space(H5Dget_space(dataset.get()), H5Sclose);
      hsize_t rows = 0;
      if (H5Sget_simple_extent_ndims(space.get()) != 1 || H5Sget_simple_extent_dims(space.get(), &rows, nullptr) != 1 ||
          rows > kRecordingLimits.max_ticks) {
        throw Error(file_, path + "/" + name, "another shape", "one row per entry");
      }
      if (!salvage && !all_chunks_written(dataset, rows))
        throw Error(file_, path + "/" + name, "rows that were never written", "an intact file");
      fewest = std::min(fewest, rows);
      most = std::max(most, rows);
      datasets_.push_back(std::move(dataset));
    }
    rows_ = names.empty() ? 0 : fewest;
    if (salvage) {
      find_intact_rows();
    } else if (fewest != most) {
      throw Error(file_, path, fmt::format("columns of {} to {} rows", fewest, most), "columns of one length");
    }
  }

  hsize_t rows() const { return rows_; }
  bool has(std::size_t column) const { return static_cast<bool>(datasets_[column]); }
  void limit(hsize_t rows) { rows_ = std::min(rows_, rows); }

  /// Throws Error if `count` rows of `size` bytes need more memory than a reader may use.
  void limit_memory(hsize_t count, std::size_t size) const {
    if (count > kRecordingLimits.max_rows_bytes / size)
      throw Error(file_, path_, fmt::format("{} rows", count),
                  fmt::format("at most {}", kRecordingLimits.max_rows_bytes / size));
  }

  /// Reads `count` rows of a column, from row `first`. Throws Error if these rows are damaged.
  void read(std::size_t column, hid_t type, std::size_t size, hsize_t first, hsize_t count,
            std::vector<std::byte>& out) const {
    limit_memory(count, size);
    out.resize(size * count);
    if (!try_read(column, type, first, count, out.data())) {
      throw Error(file_, fmt::format("{}, rows {} to {}", path_, first, first + count), "damaged data",
                  "an intact file");
    }
  }

 private:
  bool try_read(std::size_t column, hid_t type, hsize_t first, hsize_t count, std::byte* out) const {
    if (count == 0) return true;
    const H5& dataset = datasets_[column];
    H5 space(H5Dget_space(dataset.get()), H5Sclose);
    H5 memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &first, nullptr, &count, nullptr) >= 0 &&
           H5Dread(dataset.get(), type, memory.get(), space.get(), H5P_DEFAULT, out) >= 0;
  }

  /// True if the file contains all chunks of the dataset. HDF5 would read a missing chunk as zeros without an error.
  static bool all_chunks_written(const H5& dataset, hsize_t rows) {
    H5 properties(H5Dget_create_plist(dataset.get()), H5Pclose);
    H5 space(H5Dget_space(dataset.get()), H5Sclose);
    hsize_t chunk = 0, written = 0;
    if (H5Pget_layout(properties.get()) != H5D_CHUNKED) return true;
    return H5Pget_chunk(properties.get(), 1, &chunk) == 1 && chunk > 0 &&
           H5Dget_num_chunks(dataset.get(), space.get(), &written) >= 0 && written == (rows + chunk - 1) / chunk;
  }

  void find_intact_rows() {
    std::vector<std::byte> scratch;
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      if (!has(i)) continue;
      H5 type(H5Dget_type(datasets_[i].get()), H5Tclose);
      H5 properties(H5Dget_create_plist(datasets_[i].get()), H5Pclose);
      const std::size_t size = H5Tget_size(type.get());
      hsize_t chunk = 0;
      if (H5Pget_layout(properties.get()) != H5D_CHUNKED || H5Pget_chunk(properties.get(), 1, &chunk) != 1 ||
          chunk == 0 || size == 0 || size * chunk > (hsize_t{1} << 28)) {
        rows_ = 0;
        return;
      }
      scratch.resize(size * chunk);
      hsize_t rows = 0;
      H5 space(H5Dget_space(datasets_[i].get()), H5Sclose);
      H5Sget_simple_extent_dims(space.get(), &rows, nullptr);
      // To find one chunk, HDF5 visits all chunks, which is slow. So this search is made only if chunks are missing.
      const bool all_there = all_chunks_written(datasets_[i], rows);
      for (hsize_t first = 0; first < rows_; first += chunk) {
        // The readable rows end at the first missing chunk.
        const bool there = all_there || chunk_exists(i, first);
        if (!there || !try_read(i, type.get(), first, std::min(chunk, rows_ - first), scratch.data())) rows_ = first;
      }
    }
  }

  bool chunk_exists(std::size_t column, hsize_t first) const {
    unsigned mask = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    return H5Dget_chunk_info_by_coord(datasets_[column].get(), &first, &mask, &address, &bytes) >= 0 &&
           address != HADDR_UNDEF;
  }

  std::string file_, path_;
  std::vector<H5> datasets_;
  hsize_t rows_ = 0;
};

template <class Message>
std::vector<ColumnName> names_of(const std::vector<Column<Message>>& columns) {
  std::vector<ColumnName> names;
  for (const auto& column : columns) {
    if (column.in_file) names.push_back({column.name, column.added});
  }
  return names;
}

template <class Message>
std::vector<Message> read_messages(const TableReader& table, const std::vector<Column<Message>>& columns, hsize_t first,
                                   hsize_t count) {
  table.limit_memory(count, sizeof(Message));
  std::vector<Message> messages(count);
  std::vector<std::byte> cells;
  std::size_t i = 0;
  for (const auto& column : columns) {
    if (!column.in_file) continue;
    if (column.set && table.has(i)) {
      const std::size_t size = size_of(column.type);
      table.read(i, h5_type(column.type), size, first, count, cells);
      for (hsize_t row = 0; row < count; ++row) column.set(messages[row], cells.data() + row * size);
    }
    ++i;
  }
  return messages;
}

template <class T>
std::vector<T> read_numbers(const TableReader& table, std::size_t column) {
  std::vector<std::byte> cells;
  table.read(column, h5_type(type_of<T>()), sizeof(T), 0, table.rows(), cells);
  std::vector<T> numbers(table.rows());
  if (!numbers.empty()) std::memcpy(numbers.data(), cells.data(), cells.size());
  return numbers;
}

std::vector<std::string> read_texts(const TableReader& table, std::size_t column, std::size_t size) {
  std::vector<std::byte> cells;
  H5 type = h5_string_type(size);
  table.read(column, type.get(), size, 0, table.rows(), cells);
  std::vector<std::string> texts;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::string text(reinterpret_cast<const char*>(cells.data()) + row * size, size);
    while (!text.empty() && text.back() == '\0') text.pop_back();
    texts.push_back(std::move(text));
  }
  return texts;
}

/// The length that the superblock (header) of an HDF5 file states, version 3: a signature of 8 bytes, the version, the
/// size of offsets, and at byte 28 the end of the file. Returns 0 for other files.
std::uint64_t stated_length(const FileBytes& bytes) {
  std::array<char, 48> block{};
  if (!bytes.read(block.data(), block.size(), 0) || std::memcmp(block.data(), "\x89HDF\r\n\x1a\n\x03\x08", 10) != 0)
    return 0;
  std::uint64_t end = 0;
  std::memcpy(&end, block.data() + 28, sizeof end);
  return end;
}

/// Reads a small dataset (from open_dataset()) with exactly `count` numbers. If `count` is 0, the dataset must be a
/// scalar. False if the dataset does not exist.
bool read_fixed(const H5& dataset, hid_t type, hsize_t count, void* out) {
  if (!dataset) return false;
  H5 space(H5Dget_space(dataset.get()), H5Sclose);
  return H5Sget_simple_extent_npoints(space.get()) == static_cast<hssize_t>(std::max<hsize_t>(count, 1)) &&
         H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) >= 0;
}

}  // namespace

struct SessionReader::Impl : Contents {
  explicit Impl(std::shared_ptr<FileBytes> file_bytes) : opened(std::move(file_bytes)) { file = opened->file(); }

  std::shared_ptr<FileBytes> opened;  // must exist longer than h5
  bool marked = false;
  H5 h5;
  TableReader ticks;

  H5 dataset(const std::string& path) const { return open_dataset(file.string(), h5.get(), path); }
  void open();
  void read_loop();
  void read_header();
  void read_events(const TableReader& table);
  void read_result();
  void find_gaps();
};

void SessionReader::Impl::open() {
  const H5Quiet quiet;
  being_recorded = is_being_recorded(opened->fd());
  const auto open_as = [&](unsigned flags) {
    // If a checksum is wrong because a writer is active, HDF5 tries again after a pause; each pause is twice as long as
    // the last. 20 attempts take a millisecond; HDF5's default of 100 attempts would practically never end.
    H5 properties(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (flags & H5F_ACC_SWMR_READ) H5Pset_metadata_read_attempts(properties.get(), being_recorded ? 20 : 1);
    if (opened->use(properties.get())) h5 = H5(H5Fopen(file.c_str(), flags, properties.get()), H5Fclose);
    return static_cast<bool>(h5);
  };
  // A killed writer leaves a mark in the file. HDF5's normal mode refuses a file with this mark, but its mode for
  // concurrent readers accepts it.
  marked = !open_as(H5F_ACC_RDONLY);
  if (marked && !open_as(H5F_ACC_RDONLY | H5F_ACC_SWMR_READ)) {
    const std::string why = h5_reason();
    // Both modes refuse a file that is shorter than its header states. So zeros are appended to the opened bytes; the
    // checksums then detect the missing part.
    if (stated_length(*opened) > opened->size()) {
      opened->lengthen(stated_length(*opened));
      if (!open_as(H5F_ACC_RDONLY)) open_as(H5F_ACC_RDONLY | H5F_ACC_SWMR_READ);
    }
    if (!h5) throw Error(file.string(), "", fmt::format("no intact HDF5 file ({})", why), "a session (.h5)");
  }
  std::string format;
  std::uint64_t version = 0, complete = 0;
  if (!get_attribute(h5.get(), "format", format) || format != kFormatName) {
    throw Error(file.string(), "attribute \"format\"", format.empty() ? "nothing" : format.substr(0, 40), kFormatName);
  }
  if (!get_attribute(h5.get(), "format_version", version) || version != kFormatVersion) {
    throw Error(file.string(), "attribute \"format_version\"", std::to_string(version), std::to_string(kFormatVersion));
  }
  read_fixed(dataset("complete"), H5T_NATIVE_UINT64, 0, &complete);
  truncated = complete != 1 || (marked && !being_recorded);
  read_header();

  auto n = as_array(lost);
  const auto read_losses = [&](std::size_t count) {
    return read_fixed(dataset("lost"), H5T_NATIVE_UINT64, count, n.data());
  };
  if (read_losses(n.size()) || read_losses(kLostAtFirst)) lost = {n[0], n[1], n[2], n[3], n[4], n[5], n[6]};
  const auto open_table = [&](TableReader& table, const std::string& path, const std::vector<ColumnName>& names) {
    table.open(file, h5.get(), path, names, truncated);
  };
  // The ticks are opened first. An active writer may add rows in the meantime, so the tables of cuts and tissue patches
  // that are opened later extend at least to the last tick.
  open_table(ticks, "ticks", names_of(tick_columns()));
  TableReader table;
  open_table(table, "cuts", names_of(cut_columns()));
  cuts = read_messages(table, cut_columns(), 0, table.rows());
  check_cuts(file.string(), cuts, header.tools.size());
  table = {};
  open_table(table, "patches", names_of(patch_columns()));
  patches = read_messages(table, patch_columns(), 0, table.rows());
  check_patches(file.string(), patches);
  table = {};
  open_table(table, "events", {{"t_ns"}, {"kind"}, {"part"}, {"text"}});
  read_events(table);
  for (const StreamSpec& spec : header.streams) {
    std::vector<ColumnName> names = {{"t_ns"}};
    for (const auto& column : spec.columns) names.push_back({column.name});
    table = {};
    open_table(table, "streams/" + spec.name, names);
    StreamData data;
    data.t = read_numbers<Nanos>(table, 0);
    check_times(file.string(), "streams/" + spec.name, data.t);
    for (std::size_t i = 1; i < names.size(); ++i) data.columns.push_back(read_numbers<double>(table, i));
    streams.push_back(std::move(data));
  }
  read_loop();
  if (!truncated) read_result();
  find_gaps();
}

void SessionReader::Impl::read_header() {
  const hid_t root = h5.get();
  const std::string name = file.string();
  const auto need = [&](bool there, const char* what) {
    if (!there) throw Error(name, what, "nothing", "a value");
  };
  double voxel_mm = 0;
  std::string files, seeds, tools, stream_specs;
  need(get_attribute(root, "program_version", header.program_version), "program_version");
  need(get_attribute(root, "compiler", header.compiler), "compiler");
  need(get_attribute(root, "date", header.date), "date");
  need(get_attribute(root, "hand", header.hand), "hand");
  need(get_attribute(root, "trainee", header.trainee), "trainee");
  need(get_attribute(root, "servo_rate_Hz", header.servo_rate), "servo_rate_Hz");
  need(get_attribute(root, "voxel_mm", voxel_mm), "voxel_mm");
  header.force_law = 0;  // 0 if the file does not state its law
  get_attribute(root, "force_law", header.force_law);
  get_attribute(root, "model", header.model);
  if (std::string warnings; get_attribute(root, "warnings", warnings)) {
    const Json levels = Json::parse(warnings, name + ": warnings");
    for (const std::string& item : levels.keys()) header.warnings[item] = levels[item].number(0, 1);
  }
  need(get_attribute(root, "vibration_band_Hz", header.vibration_band), "vibration_band_Hz");
  need(get_attribute(root, "position_step_m", header.position_step), "position_step_m");
  std::uint64_t gives_torque = 1;
  need(get_attribute(root, "gives_torque", gives_torque), "gives_torque");
  header.gives_torque = gives_torque != 0;
  if (!(header.position_step > 0 && header.position_step < 1)) header.position_step = 0;
  if (!std::isfinite(header.vibration_band) || header.vibration_band < 0) header.vibration_band = 0;
  need(read_text(dataset("header/scene"), header.scene_json), "header/scene");
  need(read_text(dataset("header/rig"), header.rig_json), "header/rig");
  need(read_text(dataset("header/files"), files), "header/files");
  need(read_text(dataset("header/seeds"), seeds), "header/seeds");
  need(read_text(dataset("header/tools"), tools), "header/tools");
  need(read_text(dataset("header/streams"), stream_specs), "header/streams");
  need(read_fixed(dataset("header/volumes_before_mm3"), H5T_NATIVE_DOUBLE, kTissueCount, header.volumes_before.data()),
       "header/volumes_before_mm3");
  for (double& v : header.volumes_before) v /= 1e9;
  header.voxel = voxel_mm / 1e3;
  check_header(name, header);

  for (const Json& f : Json::parse(files, name + ": header/files").items()) {
    header.files.push_back({f["path"].string(), static_cast<std::uint64_t>(f["bytes"].integer(0)), f["hash"].string()});
  }
  for (const Json& s : Json::parse(seeds, name + ": header/seeds").items()) {
    const std::string digits = s["seed"].string();
    std::uint64_t seed = 0;
    const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), seed);
    if (parsed.ec != std::errc() || parsed.ptr != digits.data() + digits.size()) s["seed"].fail("an integer as text");
    header.seeds.emplace_back(s["name"].string(), seed);
  }
  for (const Json& t : Json::parse(tools, name + ": header/tools").items()) header.tools.push_back(t.string());
  for (const Json& s : Json::parse(stream_specs, name + ": header/streams").items()) {
    StreamSpec spec;
    spec.name = s["name"].string();
    for (const Json& c : s["columns"].items()) spec.columns.push_back({c["name"].string(), c["unit"].string()});
    header.streams.push_back(std::move(spec));
  }
}

/// Reads the group "loop", which a truncated file may lack.
void SessionReader::Impl::read_loop() {
  LoopFields fields;
  const auto read = [&](const std::string& name, Type type, const char*, const std::string&, auto& numbers) {
    return read_fixed(dataset("loop/" + name), h5_type(type), numbers.size(), numbers.data());
  };
  if (open_group(file.string(), h5.get(), "loop") && fields.each(read) && fields.times[0] > 0 && fields.times[1] > 0)
    loop = fields.report();
}

void SessionReader::Impl::read_events(const TableReader& table) {
  const auto t = read_numbers<Nanos>(table, 0);
  const auto kind = read_numbers<std::uint8_t>(table, 1);
  const auto part = read_numbers<std::uint32_t>(table, 2);
  const auto text = read_texts(table, 3, kEventText);
  check_times(file.string(), "events", t);
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (part[i] > 0 && !events.empty()) {
      events.back().text += text[i];
    } else {
      const bool known = kind[i] < kEventKindCount;
      events.push_back({t[i], known ? static_cast<EventKind>(kind[i]) : EventKind::kNote, text[i]});
    }
  }
}

void SessionReader::Impl::read_result() {
  SessionResult r;
  if (!open_group(file.string(), h5.get(), "result")) throw Error(file.string(), "result", "nothing", "a group");
  const auto volumes = [&](const char* name, PerTissue& out) {
    if (!read_fixed(dataset(name), H5T_NATIVE_DOUBLE, kTissueCount, out.data())) return false;
    for (double& v : out) v /= 1e9;
    return std::all_of(out.begin(), out.end(), [](double v) { return v >= 0 && v <= kRecordingLimits.max_volume; });
  };
  r.has_volumes = volumes("result/volumes_after_mm3", r.volumes_after);
  r.has_ideal = volumes("result/volumes_ideal_mm3", r.volumes_ideal);
  if (!r.has_volumes) r.volumes_after = {};
  if (!r.has_ideal) r.volumes_ideal = {};
  double mm = -1;
  read_fixed(dataset("result/min_pulp_distance_mm"), H5T_NATIVE_DOUBLE, 0, &mm);
  r.min_pulp_distance = std::isfinite(mm) ? mm / 1e3 : -1;
  read_fixed(dataset("result/field_hash"), H5T_NATIVE_UINT64, 0, &r.field_hash);

  TableReader index, bytes;
  index.open(file, h5.get(), "pictures", {{"name"}, {"title"}, {"offset"}, {"bytes"}}, false);
  bytes.open(file, h5.get(), "pictures", {{"png"}}, false);
  const auto names = read_texts(index, 0, kPictureText), titles = read_texts(index, 1, kPictureText);
  const auto offsets = read_numbers<std::uint64_t>(index, 2), sizes = read_numbers<std::uint64_t>(index, 3);
  std::vector<std::byte> cells;
  std::uint64_t end = 0;  // end of the previous picture's bytes; pictures must not overlap
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (offsets[i] < end || offsets[i] > bytes.rows() || sizes[i] > bytes.rows() - offsets[i]) {
      throw Error(file.string(), fmt::format("pictures, row {}", i), "bytes of another one or beyond the end",
                  "an intact file");
    }
    end = offsets[i] + sizes[i];
    bytes.read(0, H5T_NATIVE_UINT8, 1, offsets[i], sizes[i], cells);
    const auto* data = reinterpret_cast<const std::uint8_t*>(cells.data());
    r.pictures.push_back({names[i], titles[i], {data, data + cells.size()}});
  }
  result = std::move(r);
}

void SessionReader::Impl::find_gaps() {
  // Checks the columns index, t_ns and cuts of all ticks, which show gaps. Other columns are checked when read.
  constexpr hsize_t kPiece = 1 << 16;
  const auto place_of = [](const char* name) {
    const auto names = names_of(tick_columns());
    return static_cast<std::size_t>(
        std::find_if(names.begin(), names.end(), [&](const ColumnName& c) { return c.name == name; }) - names.begin());
  };
  const std::size_t index_at = place_of("index"), t_at = place_of("t_ns"), cuts_at = place_of("cuts");
  std::vector<std::byte> index, t, made;
  const auto number = []<class T>(const std::vector<std::byte>& cells, hsize_t row, T) {
    T value;
    std::memcpy(&value, cells.data() + row * sizeof value, sizeof value);
    return value;
  };
  std::uint64_t last_index = 0, last_made = 0;
  Nanos last_t = 0;
  for (hsize_t first = 0; first < ticks.rows(); first += kPiece) {
    const hsize_t count = std::min(kPiece, ticks.rows() - first);
    ticks.read(index_at, H5T_NATIVE_UINT64, sizeof(std::uint64_t), first, count, index);
    ticks.read(t_at, H5T_NATIVE_INT64, sizeof(Nanos), first, count, t);
    ticks.read(cuts_at, H5T_NATIVE_UINT64, sizeof(std::uint64_t), first, count, made);
    for (hsize_t row = 0; row < count; ++row) {
      const std::uint64_t i = number(index, row, std::uint64_t{});
      const Nanos at = number(t, row, Nanos{});
      const auto wrong = [&](const char* what, std::uint64_t found, std::uint64_t least) {
        throw Error(file.string(), fmt::format("ticks, row {}, {}", first + row, what), std::to_string(found),
                    fmt::format("at least {}", least));
      };
      const bool begins = first + row == 0;
      if (!begins && i <= last_index) wrong("index", i, last_index + 1);
      const std::uint64_t so_far = number(made, row, std::uint64_t{});
      if (so_far < last_made) wrong("cuts", so_far, last_made);
      if (!begins && i - last_index > 1) gaps.push_back({last_t, at, last_index, i - last_index - 1, 0});
      last_index = i, last_t = at, last_made = so_far;
    }
  }
  // Adds the number of missing cuts to the gap of missing ticks in which they were made, or else to a new gap.
  const auto missing = [&](std::uint64_t count, std::uint64_t after_tick, std::uint64_t before_tick, Nanos from,
                           Nanos to) {
    const auto of_ticks = std::find_if(gaps.begin(), gaps.end(), [&](const Gap& gap) {
      return gap.ticks > 0 && gap.after_tick < before_tick && gap.after_tick + gap.ticks >= after_tick;
    });
    if (of_ticks != gaps.end()) {
      of_ticks->cuts += count;
    } else {
      gaps.push_back({from, to, after_tick, 0, count});
    }
  };
  Cut before;
  for (const Cut& cut : cuts) {
    if (cut.index > before.index + 1) missing(cut.index - before.index - 1, before.tick, cut.tick, before.t, cut.t);
    before = cut;
  }
  if (last_made > before.index) missing(last_made - before.index, before.tick, last_index, before.t, last_t);
  std::stable_sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) { return a.from < b.from; });
}

OpenedSession::OpenedSession(const std::filesystem::path& file) : bytes_(std::make_shared<FileBytes>(file)) {}
const std::filesystem::path& OpenedSession::file() const {
  return bytes_->file();
}
std::span<const std::byte> OpenedSession::bytes() const {
  return bytes_->in_memory();
}

SessionReader::SessionReader(const OpenedSession& session) : impl_(std::make_unique<Impl>(session.bytes_)) {
  try {
    impl_->open();
    contents_ = std::move(*impl_);
  } catch (const Error& e) {
    std::error_code code;
    if (impl_->being_recorded || !std::filesystem::exists(journal_of(session.file()), code)) throw;
    throw Error(fmt::format("{}; a power failure may have interrupted it: typodont repair", e.what()));
  }
}
SessionReader::~SessionReader() = default;
SessionReader::SessionReader(SessionReader&&) noexcept = default;
SessionReader& SessionReader::operator=(SessionReader&&) noexcept = default;

std::uint64_t SessionReader::tick_count() const {
  return impl_->ticks.rows();
}

std::vector<ServoTick> SessionReader::ticks(std::uint64_t first, std::uint64_t count) const {
  const H5Quiet quiet;
  first = std::min(first, tick_count());
  std::vector<ServoTick> ticks =
      read_messages(impl_->ticks, tick_columns(), first, std::min(count, tick_count() - first));
  check_ticks(file().string(), ticks, first, header().tools.size());
  return ticks;
}

const StreamData* SessionReader::stream(std::string_view name) const {
  const auto& specs = header().streams;
  for (std::size_t i = 0; i < specs.size(); ++i)
    if (specs[i].name == name) return &streams()[i];
  return nullptr;
}
namespace {

/// Rewrites an interrupted recording as an ordinary file, without result.
void write_again(const SessionReader& reader, const std::filesystem::path& out) {
  WriterOptions options;
  options.rewrites = true;
  options.lost_before = reader.lost();
  options.disk_needed = options.disk_low = options.disk_reserve = 0;
  SessionWriter writer(out, reader.header(), options);
  writer.append(reader.patches());
  writer.append(reader.cuts());
  if (reader.loop()) writer.loop(*reader.loop());
  for (const SessionEvent& event : reader.events()) writer.append(event);
  for (std::size_t s = 0; s < reader.streams().size(); ++s) {
    const StreamData& stream = reader.streams()[s];
    std::vector<double> values(stream.columns.size());
    for (std::size_t row = 0; row < stream.t.size(); ++row) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = stream.columns[i][row];
      writer.append(s, stream.t[row], values);
    }
  }
  constexpr std::uint64_t kPiece = 4096;
  for (std::uint64_t first = 0; first < reader.tick_count(); first += kPiece)
    writer.append(reader.ticks(first, kPiece));
  writer.flush();
  if (writer.status().state != WriterStatus::State::kRecording)
    throw Error(reader.file().string(), "", writer.status().message, "a writable place to repair it");
}

}  // namespace

bool repair_session(const std::filesystem::path& file) {
  std::error_code code;
  if (std::filesystem::exists(signature_file(file), code))
    throw Error(file.string(), "", "a signed session", "an unsigned recording that was cut off");
  const OpenedSession session(file);
  FileBytes& bytes = *session.bytes_;
  if (is_being_recorded(bytes.fd())) return false;
  std::vector<Change> changes = journal_changes(bytes);
  const bool has_changes = !changes.empty();
  bytes.show_with(std::move(changes));
  std::optional<PartialFile> partial;
  {
    const SessionReader reader(session);
    // A file that its program closed is intact, even if it contains no result.
    if (!reader.impl_->marked && !has_changes) return false;
    partial.emplace(file, FileKind::kSession, Over::kItsInput, "repaired");
    if (!reader.impl_->marked) {
      bytes.write_to(partial->path());
    } else {
      write_again(reader, partial->path());
    }
  }
  // Since the recording was opened, another file may have got its name. Such a file must not be replaced.
  struct stat opened {
  }, named{};
  if (::fstat(bytes.fd(), &opened) != 0 || ::stat(file.c_str(), &named) != 0 || opened.st_ino != named.st_ino ||
      opened.st_dev != named.st_dev)
    throw Error(file.string(), "", "another file than the one that was read", "the recording to repair");
  partial->keep();
  if (std::filesystem::remove(journal_of(file), code)) sync_folder_of(file);
  return true;
}

}  // namespace typodont::session
