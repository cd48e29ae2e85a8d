// Tests what remains of a recording after a power cut. Every write, sync, rename and removal of the recorder is logged.
// For a hundred random moments (in ./run stress, for every moment), the test writes the worst files that POSIX allows.
// Of data that was not synced, any sectors may exist, in any order, and a file may have any length. The names of files
// are those of the folder's last sync or of any later step.
#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdarg>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/partial_file.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/campaign.h"
#include "tests/support/session_fixture.h"

namespace {

/// One step that the disk sees. Files are identified by their inode, because a rename does not make a new file.
struct Step {
  enum class Kind { kWrite, kResize, kSync, kSyncFolder, kMake, kRename, kRemove } kind;
  ino_t file = 0;
  std::uint64_t place = 0;  // or the length
  std::string bytes;
  std::string name, to;  // within the folder
};

struct DiskLog {
  bool on = false;
  std::string folder;
  std::vector<Step> steps;
  std::map<ino_t, bool> known;
};
DiskLog g_disk;

/// Returns the name within the watched folder. Returns an empty text for a path in another folder.
std::string name_in_folder(const std::string& path) {
  const std::filesystem::path p(path);
  return g_disk.on && p.parent_path() == g_disk.folder ? p.filename().string() : "";
}

void log_fd(Step::Kind kind, int fd, std::uint64_t place = 0, const void* bytes = nullptr, std::size_t size = 0) {
  if (!g_disk.on) return;
  std::array<char, 4096> path{};
  const ssize_t n = readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), path.data(), path.size() - 1);
  if (n <= 0) return;
  if (g_disk.folder == path.data()) {
    if (kind == Step::Kind::kSync) g_disk.steps.push_back({Step::Kind::kSyncFolder, 0, 0, {}, {}, {}});
    return;
  }
  const std::string name = name_in_folder(path.data());
  struct stat info {};
  if (name.empty() || fstat(fd, &info) != 0) return;
  if (!g_disk.known[info.st_ino]) {
    g_disk.known[info.st_ino] = true;
    g_disk.steps.push_back({Step::Kind::kMake, info.st_ino, 0, {}, name, {}});
  }
  g_disk.steps.push_back(
      {kind, info.st_ino, place, std::string(static_cast<const char*>(bytes ? bytes : ""), size), name, {}});
}

template <class F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// The following functions replace the C library's functions that the recorder calls.
extern "C" {
int open(const char* path, int flags, ...) {
  static const auto real = next<int (*)(const char*, int, ...)>("open");
  mode_t mode = 0;
  if (flags & O_CREAT) {
    va_list rest;
    va_start(rest, flags);
    mode = va_arg(rest, mode_t);
    va_end(rest);
  }
  const int fd = real(path, flags, mode);
  if (fd >= 0 && (flags & O_CREAT)) log_fd(Step::Kind::kResize, fd);  // made, and empty
  return fd;
}
ssize_t pwrite(int fd, const void* bytes, size_t size, off_t place) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite");
  const ssize_t n = real(fd, bytes, size, place);
  if (n > 0) log_fd(Step::Kind::kWrite, fd, static_cast<std::uint64_t>(place), bytes, static_cast<std::size_t>(n));
  return n;
}
int ftruncate(int fd, off_t length) noexcept {
  static const auto real = next<int (*)(int, off_t)>("ftruncate");
  const int result = real(fd, length);
  if (result == 0) log_fd(Step::Kind::kResize, fd, static_cast<std::uint64_t>(length));
  return result;
}
int fsync(int fd) {
  log_fd(Step::Kind::kSync, fd);
  return 0;  // the log is the disk
}
int fdatasync(int fd) {
  log_fd(Step::Kind::kSync, fd);
  return 0;
}
int rename(const char* from, const char* to) noexcept {
  static const auto real = next<int (*)(const char*, const char*)>("rename");
  const int result = real(from, to);
  if (result == 0 && !name_in_folder(to).empty())
    g_disk.steps.push_back({Step::Kind::kRename, 0, 0, {}, name_in_folder(from), name_in_folder(to)});
  return result;
}
int unlink(const char* path) noexcept {
  static const auto real = next<int (*)(const char*)>("unlink");
  const int result = real(path);
  if (result == 0 && !name_in_folder(path).empty())
    g_disk.steps.push_back({Step::Kind::kRemove, 0, 0, {}, name_in_folder(path), {}});
  return result;
}
}

namespace typodont::session {
namespace {

using namespace test;

constexpr std::size_t kSector = 512;    // bytes that a disk writes whole or not at all
constexpr std::size_t kPerFlush = 450;  // ticks
constexpr std::uint64_t kFlushes = 12;

/// A file as the disk may have it.
struct Image {
  std::string synced;             // for certain
  std::vector<const Step*> then;  // since the last sync, in any part and order

  std::string after_power_cut(std::mt19937_64& random) const {
    std::string bytes = synced;
    // A power cut keeps changes of the file's length in their order, but contents may be written in any order.
    const std::size_t lengths = then.empty() ? 0 : random() % (then.size() + 1);
    for (std::size_t i = 0; i < lengths; ++i) {
      const Step& s = *then[i];
      if (s.kind == Step::Kind::kResize)
        bytes.resize(s.place);
      else
        bytes.resize(std::max(bytes.size(), s.place + s.bytes.size()), '\0');
    }
    const unsigned keep_in_8 = static_cast<unsigned>(random() % 9);
    for (const Step* s : then) {
      for (std::size_t at = 0; at < s->bytes.size();) {
        const std::size_t place = s->place + at, size = std::min(kSector - place % kSector, s->bytes.size() - at);
        if (random() % 8 < keep_in_8 && place + size <= bytes.size()) bytes.replace(place, size, s->bytes, at, size);
        at += size;
      }
    }
    return bytes;
  }
  void apply_all() {
    for (const Step* s : then) {
      if (s->kind == Step::Kind::kResize) {
        synced.resize(s->place);
      } else {
        synced.resize(std::max(synced.size(), s->place + s->bytes.size()), '\0');
        synced.replace(s->place, s->bytes.size(), s->bytes);
      }
    }
    then.clear();
  }
};

struct Disk {
  std::map<ino_t, Image> files;
  std::map<std::string, ino_t> names;  // as the folder's last sync has them
  std::vector<const Step*> later_names;

  static void change(std::map<std::string, ino_t>& names, const Step& s) {
    if (s.kind == Step::Kind::kMake) names[s.name] = s.file;
    if (s.kind == Step::Kind::kRemove) names.erase(s.name);
    if (s.kind == Step::Kind::kRename && names.contains(s.name)) {
      names[s.to] = names[s.name];
      names.erase(s.name);
    }
  }
  void step(const Step& s) {
    switch (s.kind) {
      case Step::Kind::kWrite:
      case Step::Kind::kResize:
        files[s.file].then.push_back(&s);
        break;
      case Step::Kind::kSync:
        files[s.file].apply_all();
        break;
      case Step::Kind::kSyncFolder:
        for (const Step* name : later_names) change(names, *name);
        later_names.clear();
        break;
      default:
        later_names.push_back(&s);
    }
  }
  void lay_down(const std::filesystem::path& folder, std::mt19937_64& random) const {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    auto there = names;
    const std::size_t done = later_names.empty() ? 0 : random() % (later_names.size() + 1);
    for (std::size_t i = 0; i < done; ++i) change(there, *later_names[i]);
    for (const auto& [name, file] : there) {
      const auto image = files.find(file);
      std::ofstream(folder / name, std::ios::binary)
          << (image == files.end() ? std::string() : image->second.after_power_cut(random));
    }
  }
};

struct Recorded {
  std::vector<Step> steps;
  std::vector<std::pair<std::size_t, std::uint64_t>> safe;  // after so many steps so many ticks are promised
  std::vector<ServoTick> ticks;
  std::vector<Cut> cuts;
};

Recorded record(const std::filesystem::path& folder, bool finish) {
  Recorded r;
  r.ticks = random_ticks(kPerFlush * kFlushes, 77);
  for (ServoTick& tick : r.ticks) tick.cuts = tick.index / 9;
  r.cuts = random_cuts(r.ticks.size() / 9, 78);
  std::filesystem::create_directories(folder);
  g_disk = {true, folder.string(), {}, {}};
  {
    SessionWriter writer(folder / "s.h5", some_header());
    r.safe.push_back({g_disk.steps.size(), 0});
    std::size_t made = 0;
    for (std::uint64_t flush = 0; flush < kFlushes; ++flush) {
      const auto ticks = std::span(r.ticks).subspan(flush * kPerFlush, kPerFlush - (flush % 3 ? 0 : 37));
      const std::size_t cuts = std::min<std::size_t>(r.ticks[(flush + 1) * kPerFlush - 1].cuts, r.cuts.size());
      writer.append(std::span(r.cuts).subspan(made, cuts - made));
      made = cuts;
      writer.append(ticks);
      if (ticks.size() < kPerFlush) {
        writer.flush();  // in the middle of a chunk, which is then written again
        r.safe.push_back({g_disk.steps.size(), flush * kPerFlush + ticks.size()});
        writer.append(std::span(r.ticks).subspan(flush * kPerFlush + ticks.size(), 37));
      }
      writer.event(ticks.back().t, EventKind::kNote, "flush " + std::to_string(flush));
      writer.flush();
      r.safe.push_back({g_disk.steps.size(), (flush + 1) * kPerFlush});
    }
    if (finish) {
      SessionResult result;
      result.pictures = {{"after", "", std::vector<std::uint8_t>(300'000, 7)}};
      EXPECT_TRUE(writer.finish(result)) << writer.status().message;
      r.safe.push_back({g_disk.steps.size(), kFlushes * kPerFlush});
    }
    g_disk.on = false;
  }
  r.steps = std::move(g_disk.steps);
  return r;
}

void expect_recovered(const std::filesystem::path& file, const Recorded& r, std::uint64_t promised,
                      const std::string& when) {
  const auto check = [&](const SessionReader& reader) {
    ASSERT_GE(reader.tick_count(), promised) << when;
    const auto ticks = reader.ticks();
    for (std::size_t i = 0; i < ticks.size(); i += 41)
      ASSERT_TRUE(same_for_replay(r.ticks[i], ticks[i])) << when << ", tick " << i;
    EXPECT_TRUE(reader.gaps().empty()) << when << in_words(reader.gaps());
    ASSERT_GE(reader.cuts().size(), ticks.empty() ? 0 : ticks.back().cuts) << when;
    for (std::size_t i = 0; i < reader.cuts().size(); i += 13) ASSERT_TRUE(same(r.cuts[i], reader.cuts()[i]));
  };
  try {
    if (repair_session(file)) {
      EXPECT_FALSE(std::filesystem::exists(file.string() + ".journal"));
    }
    check(SessionReader(file));
  } catch (const Error& e) {
    FAIL() << when << ": " << e.what();
  }
}

TEST(PowerCut, AtAnyMomentFlushedDataAreReadBack) {
  TemporaryFolder folder;
  const Recorded r = record(folder / "recorded", /*finish=*/true);
  ASSERT_GT(r.steps.size(), 300u);
  std::mt19937_64 random(4711);
  Disk disk;
  std::size_t next_safe = 0;
  std::uint64_t promised = 0;
  bool begun = false;
  std::size_t cuts = 0;
  const auto wanted = static_cast<std::size_t>(typodont::test::campaign(120));
  for (std::size_t i = 0; i < r.steps.size(); ++i) {
    while (next_safe < r.safe.size() && r.safe[next_safe].first <= i) {
      promised = r.safe[next_safe++].second;
      begun = true;
    }
    if (begun && random() % r.steps.size() < wanted) {
      disk.lay_down(folder / "cut", random);
      expect_recovered(folder / "cut" / "s.h5", r, promised, "cut before step " + std::to_string(i));
      if (HasFailure()) return;
      ++cuts;
    }
    disk.step(r.steps[i]);
  }
  EXPECT_GT(cuts, std::min(wanted, r.steps.size()) / 2);
}

TEST(PowerCut, AfterTheEndTheRecordingIsCompleteAndHasNoJournal) {
  TemporaryFolder folder;
  const Recorded r = record(folder / "recorded", /*finish=*/true);
  Disk disk;
  for (const Step& step : r.steps) disk.step(step);
  std::mt19937_64 random(1);
  for (int i = 0; i < 5; ++i) {
    disk.lay_down(folder / "cut", random);
    const SessionReader reader(folder / "cut" / "s.h5");
    EXPECT_FALSE(reader.truncated());
    EXPECT_EQ(reader.tick_count(), kFlushes * kPerFlush);
    EXPECT_EQ(reader.result()->pictures.size(), 1u);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "cut"), {}), 1);
  }
}

TEST(PowerCut, AReplacedFileIsCompletelyOldOrCompletelyNew) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "written");
  const std::string old_content(30'000, 'o'), new_content(50'000, 'n');
  const auto file = folder / "written" / "report.html";
  std::ofstream(file) << old_content;
  struct stat info {};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  Disk disk;
  disk.names["report.html"] = info.st_ino;
  disk.files[info.st_ino].synced = old_content;
  g_disk = {true, (folder / "written").string(), {}, {}};
  {
    PartialFile partial(file);
    const int fd = ::open(partial.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    for (std::size_t at = 0; at < new_content.size(); at += 9'999) {
      const std::string piece = new_content.substr(at, 9'999);
      ASSERT_EQ(::pwrite(fd, piece.data(), piece.size(), static_cast<off_t>(at)), static_cast<ssize_t>(piece.size()));
    }
    ::close(fd);
    partial.keep();
  }
  g_disk.on = false;
  const std::vector<Step> steps = std::move(g_disk.steps);
  std::mt19937_64 random(5);
  const auto content = [&] {
    disk.lay_down(folder / "cut", random);
    return read_text(folder / "cut" / "report.html");
  };
  for (const Step& step : steps) {
    for (int i = 0; i < 30; ++i) {
      const std::string found = content();
      ASSERT_TRUE(found == old_content || found == new_content) << found.size() << " bytes";
    }
    disk.step(step);
  }
  for (int i = 0; i < 30; ++i) ASSERT_EQ(content(), new_content);
}

TEST(PowerCut, AnOldJournalDoesNotChangeANewRecordingOfTheSameName) {
  TemporaryFolder folder;
  std::ofstream(folder / "s.h5.journal", std::ios::binary) << "an older recording's";
  {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(random_ticks(100, 5));
    ASSERT_TRUE(writer.finish({}));
  }
  EXPECT_FALSE(repair_session(folder / "s.h5"));
  EXPECT_EQ(SessionReader(folder / "s.h5").tick_count(), 100u);
}

}  // namespace
}  // namespace typodont::session
