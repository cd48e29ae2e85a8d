#include <gmock/gmock.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "engine/base/cache.h"
#include "engine/base/sha256.h"
#include "engine/session/hash.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;
using SessionFile = FolderTest;

void write_session(const std::filesystem::path& file, std::span<const ServoTick> ticks, const SessionHeader& header) {
  SessionWriter writer(file, header);
  writer.append(ticks);
  ASSERT_TRUE(writer.finish({}));
}
/// Options of a writer whose disk has `free` bytes.
struct Disk {
  std::uint64_t free = 1u << 30;
  WriterOptions options;
  Disk() {
    options.free_bytes = [this] { return free; };
  }
  Disk(const Disk&) = delete;
};

TEST_F(SessionFile, DataForAReplayAreReadBackBitForBit) {
  const auto ticks = random_ticks(3001, 1);
  const auto cuts = random_cuts(517, 2);
  const auto patches = random_patches(40, 3);
  SessionResult result;
  result.has_volumes = true;
  result.volumes_after[1] = 3.2e-7;
  result.field_hash = 0xfedcba9876543211u;
  result.min_pulp_distance = 1.5e-3;
  result.pictures = {{"before", "Vorher, 之前", {1, 2, 3, 0, 255}}, {"after", "", {}}, {"during", "", {9}}};
  const std::vector<SessionEvent> events = {
      {5, EventKind::kTool, "{\"tool\": \"round_014\"}"},
      {6, EventKind::kNote, ""},
      {7, EventKind::kNote, std::string(100, 'x') + "ä牙" + std::string(700, 'y')},
  };
  {
    SessionWriter writer(folder / "s.h5", some_header());
    // Writes parts whose sizes do not fit the chunks.
    for (std::size_t i = 0; i < ticks.size(); i += 37) {
      writer.append(std::span(ticks).subspan(i, std::min<std::size_t>(37, ticks.size() - i)));
    }
    writer.append(cuts);
    writer.append(patches);
    for (const auto& event : events) writer.append(event);
    for (int i = 0; i < 300; ++i) writer.append(0, i, std::array{0.1 * i, -0.2 * i});
    writer.append(1, 9, std::array{0.25});
    ASSERT_TRUE(writer.finish(result)) << writer.status().message;
    EXPECT_EQ(writer.status().ticks, ticks.size());
  }
  const SessionReader reader(folder / "s.h5");
  EXPECT_FALSE(reader.truncated());
  EXPECT_FALSE(reader.being_recorded());
  EXPECT_FALSE(reader.lost().any());
  const auto back = reader.ticks();
  ASSERT_EQ(back.size(), ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) ASSERT_TRUE(same_for_replay(ticks[i], back[i])) << i;
  ASSERT_EQ(reader.cuts().size(), cuts.size());
  for (std::size_t i = 0; i < cuts.size(); ++i) ASSERT_TRUE(same(cuts[i], reader.cuts()[i])) << i;
  ASSERT_EQ(reader.patches().size(), patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) ASSERT_TRUE(same(patches[i], reader.patches()[i])) << i;
  EXPECT_EQ(reader.events(), events);
  ASSERT_EQ(reader.streams().size(), 2u);
  ASSERT_EQ(reader.streams()[0].t.size(), 300u);
  EXPECT_EQ(reader.streams()[0].columns[1][299], -0.2 * 299);
  EXPECT_EQ(reader.streams()[1].columns[0], std::vector{0.25});
  ASSERT_TRUE(reader.result());
  EXPECT_EQ(reader.result()->field_hash, result.field_hash);
  EXPECT_EQ(reader.result()->pictures, result.pictures);
  EXPECT_TRUE(reader.result()->has_volumes);
  EXPECT_FALSE(reader.result()->has_ideal);
  EXPECT_NEAR(reader.result()->volumes_after[1], 3.2e-7, 1e-21);
  EXPECT_NEAR(reader.result()->min_pulp_distance, 1.5e-3, 1e-17);

  // Parts read from the middle have the same rows.
  const auto piece = reader.ticks(1000, 50);
  ASSERT_EQ(piece.size(), 50u);
  EXPECT_TRUE(same_for_replay(piece[7], ticks[1007]));
  EXPECT_TRUE(reader.ticks(5000, 10).empty());
}

TEST_F(SessionFile, ColumnsInPeoplesUnitsComeBackWithinOneUnitInTheLastPlace) {
  const auto ticks = random_ticks(2000, 4);
  write_session(folder / "s.h5", ticks, some_header());
  const auto back = SessionReader(folder / "s.h5").ticks();
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(ulps(ticks[i].X_WG.p[k], back[i].X_WG.p[k]), 1);
      EXPECT_LE(ulps(ticks[i].tau_T_W[k], back[i].tau_T_W[k]), 1);
    }
    EXPECT_LE(ulps(ticks[i].depth, back[i].depth), 1);
    EXPECT_LE(ulps(ticks[i].contact_area, back[i].contact_area), 1);
    EXPECT_LE(ulps(ticks[i].energy, back[i].energy), 1);
    EXPECT_LE(ulps(ticks[i].spindle, back[i].spindle), 1);
    for (int k = 0; k < kTissueCount; ++k) EXPECT_LE(ulps(ticks[i].removed[k], back[i].removed[k]), 1);
  }
}

TEST_F(SessionFile, AnyBitsOfTheHandAreKeptEvenNotANumber) {
  std::vector<ServoTick> ticks(4);
  for (std::size_t i = 0; i < ticks.size(); ++i) ticks[i].index = i;
  ticks[0].X_WT.p = {std::nan(""), -0.0, 5e-324};
  ticks[1].X_WT.p = {1e308, -1e308, std::numeric_limits<double>::infinity()};
  ticks[2].X_WT.R = {0, -0.0, 1e-310, std::nextafter(1.0, 2.0)};
  ticks[3].f_T_W = {-0.0, 1.0 / 3.0, std::nextafter(0.1, 1.0)};
  write_session(folder / "s.h5", ticks, some_header());
  const auto back = SessionReader(folder / "s.h5").ticks();
  ASSERT_EQ(back.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(same_for_replay(ticks[i], back[i])) << i;
}

TEST_F(SessionFile, TheHeaderIsReadBack) {
  const SessionHeader h = some_header();
  { ASSERT_TRUE(SessionWriter(folder / "s.h5", h).finish({})); }
  const SessionReader reader(folder / "s.h5");
  const SessionHeader& b = reader.header();
  EXPECT_EQ(b.scene_json, h.scene_json);
  EXPECT_EQ(b.rig_json, h.rig_json);
  EXPECT_EQ(b.files, h.files);
  EXPECT_EQ(b.hand, h.hand);
  EXPECT_EQ(b.trainee, "");
  EXPECT_EQ(b.seeds, h.seeds);
  EXPECT_EQ(b.tools, h.tools);
  EXPECT_EQ(b.streams, h.streams);
  EXPECT_EQ(b.servo_rate, 1000);
  EXPECT_EQ(b.vibration_band, 150);
  EXPECT_EQ(b.position_step, 0.055e-3);
  EXPECT_FALSE(b.gives_torque);
  EXPECT_DOUBLE_EQ(b.voxel, 1e-4);
  EXPECT_DOUBLE_EQ(b.volumes_before[1], 3.25e-7);
  EXPECT_EQ(b.date, h.date);
  EXPECT_EQ(b.program_version, TYPODONT_VERSION);
  EXPECT_EQ(b.compiler, SessionHeader::compiler_of_this_build());
  EXPECT_EQ(reader.tick_count(), 0u);
  EXPECT_FALSE(reader.truncated());
}

TEST_F(SessionFile, AToolTakenUpIsInItsTickAndAnEventByName) {
  auto ticks = random_ticks(30, 71);
  for (std::size_t i = 10; i < ticks.size(); ++i) ticks[i].tool = i < 20 ? 1 : 2;
  SessionHeader header = some_header();
  header.tools = {"round_012", "explorer", "flame_012"};
  write_session(folder / "s.h5", ticks, header);
  const SessionReader session(folder / "s.h5");
  const auto back = session.ticks();
  ASSERT_EQ(back.size(), ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) EXPECT_EQ(back[i].tool, ticks[i].tool) << i;
  EXPECT_EQ(session.events(), (std::vector<SessionEvent>{{ticks[10].t, EventKind::kTool, "explorer"},
                                                         {ticks[20].t, EventKind::kTool, "flame_012"}}));
}

TEST_F(SessionFile, LoopTimingIsReadBackAlsoFromARepairedSession) {
  const LoopReport loop = some_loop();
  const auto expect_same = [&](const std::optional<LoopReport>& read) {
    ASSERT_TRUE(read);
    EXPECT_EQ(read->timing.ticks, 60'000u);
    EXPECT_EQ(read->timing.misses, 1u);
    EXPECT_EQ(read->timing.worst_index, 41'000u);
    EXPECT_EQ(read->timing.worst_tick, 1'700'000);
    EXPECT_EQ(read->timing.worst_jitter, loop.timing.worst_jitter);
    EXPECT_EQ(read->timing.period, 1'000'000);
    EXPECT_EQ(read->timing.jitter.counts, loop.timing.jitter.counts);
    EXPECT_EQ(read->timing.work.counts, loop.timing.work.counts);
    EXPECT_TRUE(read->fifo && read->memory_locked && !read->pinned && read->armed);
    EXPECT_EQ(read->words(), "pinning refused");
    EXPECT_EQ(read->heat, 0.25);
    EXPECT_EQ(read->worst_heat, 0.93);
    EXPECT_EQ(read->bearable_force, 4.5);
    EXPECT_EQ(read->safety, loop.safety);
  };
  {
    SessionWriter writer(folder / "whole.h5", some_header());
    writer.loop(LoopReport{});  // the newest counts
    writer.loop(loop);
    ASSERT_TRUE(writer.finish({}));
  }
  expect_same(SessionReader(folder / "whole.h5").loop());
  SessionWriter writer(folder / "open.h5", some_header());
  writer.loop(loop);
  writer.flush();
  std::filesystem::copy_file(folder / "open.h5", folder / "cut.h5");  // as a kill would leave it
  expect_same(SessionReader(folder / "cut.h5").loop());
  ASSERT_TRUE(repair_session(folder / "cut.h5"));
  expect_same(SessionReader(folder / "cut.h5").loop());
  { ASSERT_TRUE(SessionWriter(folder / "none.h5", some_header()).finish({})); }
  EXPECT_FALSE(SessionReader(folder / "none.h5").loop());
}

TEST_F(SessionFile, EqualSessionsAreEqualBytes) {
  const auto ticks = random_ticks(1500, 5);
  WriterOptions options;
  options.whole_or_nothing = true;
  for (const char* name : {"a.h5", "b.h5"}) {
    SessionWriter writer(folder / name, some_header(), options);
    writer.append(ticks);
    ASSERT_TRUE(writer.finish({}));
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // another second: no file may know when it was made
  }
  EXPECT_EQ(read_text(folder / "a.h5"), read_text(folder / "b.h5"));
}

TEST_F(SessionFile, RepairedHoldsEveryEventOnce) {
  auto ticks = random_ticks(900, 7);
  for (std::size_t i = 0; i < ticks.size(); ++i)
    ticks[i].tool = static_cast<std::uint32_t>(i / 300 % 2);  // another one is taken up twice
  SessionWriter writer(folder / "open.h5", some_header());
  writer.event(0, EventKind::kNote, "the beginning");
  writer.append(ticks);
  writer.flush();
  std::filesystem::copy_file(folder / "open.h5", folder / "cut.h5");  // as a kill would leave it
  const std::vector<SessionEvent> before = SessionReader(folder / "cut.h5").events();
  ASSERT_EQ(before.size(), 3u);
  ASSERT_TRUE(repair_session(folder / "cut.h5"));
  const SessionReader repaired(folder / "cut.h5");
  ASSERT_EQ(repaired.events().size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(repaired.events()[i].t, before[i].t);
    EXPECT_EQ(repaired.events()[i].text, before[i].text);
  }
  EXPECT_EQ(repaired.tick_count(), ticks.size());
}

TEST_F(SessionFile, GarbageIsAnErrorThatNamesTheFile) {
  std::ofstream(folder / "garbage.h5") << std::string(5000, 'x');
  std::ofstream(folder / "empty.h5") << "";
  EXPECT_THAT(refusal([&] { SessionReader r(folder / "garbage.h5"); }),
              HasSubstr("garbage.h5: found no intact HDF5 file"));
  EXPECT_THAT(refusal([&] { SessionReader r(folder / "empty.h5"); }), HasSubstr("empty.h5: found no intact HDF5 file"));
  EXPECT_THAT(refusal([&] { SessionReader r(folder / "none.h5"); }),
              HasSubstr("none.h5: found No such file or directory"));
  EXPECT_THAT(refusal([&] { SessionReader r(folder.path()); }), HasSubstr("a directory"));
}

TEST(SessionWriter, AnUnwritablePathIsAnErrorImmediately) {
  TemporaryFolder folder;
  EXPECT_THAT(refusal([&] { SessionWriter w("/nowhere/s.h5", some_header()); }),
              HasSubstr("/nowhere/s.h5: found No such file or directory"));
  EXPECT_THAT(refusal([&] { SessionWriter w(folder.path(), some_header()); }), HasSubstr("a directory"));
  SessionHeader bad = some_header();
  bad.streams[0].columns[0].name = "../x";
  EXPECT_THAT(refusal([&] { SessionWriter w(folder / "s.h5", bad); }), HasSubstr("stream head"));
}

TEST(SessionWriter, AFileThatIsBeingRecordedIsNotOverwritten) {
  TemporaryFolder folder;
  SessionWriter writer(folder / "s.h5", some_header());
  EXPECT_THAT(refusal([&] { SessionWriter w(folder / "s.h5", some_header()); }), HasSubstr("being recorded"));
}

TEST(SessionWriter, ADeletedOrReplacedRecordingIsReportedAtTheNextWrite) {
  for (const bool replaced : {false, true}) {
    TemporaryFolder folder;
    const auto file = folder / "s.h5";
    SessionWriter writer(file, some_header());
    writer.append(random_ticks(100, 3));
    writer.flush();
    EXPECT_EQ(writer.status().ticks, 100u);
    std::filesystem::remove(file);
    if (replaced) std::ofstream(file) << "of somebody else";
    writer.append(random_ticks(100, 4));
    writer.flush();
    EXPECT_EQ(writer.status().state, WriterStatus::State::kFailed);
    EXPECT_NE(writer.status().message.find("deleted or replaced"), std::string::npos) << writer.status().message;
    EXPECT_EQ(writer.status().lost.ticks_disk, 100u);
    EXPECT_FALSE(writer.finish({}));
    EXPECT_EQ(std::filesystem::exists(file), replaced);
    EXPECT_FALSE(std::filesystem::exists(file.string() + ".journal"));
  }
}

TEST(SessionWriter, ARecordingThatAnotherProgramShortensIsReportedAtTheNextWrite) {
  TemporaryFolder folder;
  SessionWriter writer(folder / "s.h5", some_header());
  writer.append(random_ticks(1000, 3));
  writer.flush();
  std::filesystem::resize_file(folder / "s.h5", std::filesystem::file_size(folder / "s.h5") - 1);
  writer.append(random_ticks(100, 4));
  writer.flush();
  EXPECT_EQ(writer.status().state, WriterStatus::State::kFailed);
  EXPECT_THAT(writer.status().message, testing::HasSubstr("shortened by another program"));
  EXPECT_FALSE(writer.finish({}));
}

TEST(SessionWriter, ARecordingThatIsNamedByItsStartLeavesAnOlderOneUntilThen) {
  TemporaryFolder folder;
  WriterOptions options;
  options.named_by_start = true;
  std::ofstream(folder / "s.h5", std::ios::binary) << "\x89HDF\r\n\x1a\n an older recording";
  const std::string older = read_text(folder / "s.h5");
  { SessionWriter writer(folder / "s.h5", some_header(), options); }
  EXPECT_EQ(read_text(folder / "s.h5"), older);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  SessionWriter writer(folder / "s.h5", some_header(), options);
  writer.start();
  EXPECT_NE(read_text(folder / "s.h5"), older);
  writer.append(random_ticks(100, 4));
  EXPECT_TRUE(writer.finish({}));
}

TEST(SessionWriter, AFullDiskIsCountedAndTheSessionGoesOn) {
  TemporaryFolder folder;
  Disk disk;
  SessionWriter writer(folder / "s.h5", some_header(), disk.options);
  disk.free = (4u << 20) - 1;
  writer.append(random_ticks(1000, 8));
  writer.append(random_cuts(5, 9));
  writer.flush();
  EXPECT_EQ(writer.status().state, WriterStatus::State::kDiskFull);
  EXPECT_EQ(writer.status().lost.ticks_disk, 1000u);
  EXPECT_EQ(writer.status().lost.cuts_disk, 5u);
  EXPECT_EQ(writer.status().ticks, 0u);
  EXPECT_THAT(writer.status().message, HasSubstr("left on the disk"));
  EXPECT_FALSE(writer.finish({}));
  EXPECT_EQ(SessionReader(folder / "s.h5").lost().ticks_disk, 1000u);
}

TEST(SessionWriter, ADiskThatIsAlmostFullIsRefusedAtTheStartAndLeavesNothing) {
  TemporaryFolder folder;
  WriterOptions options;
  options.free_bytes = [] { return std::uint64_t{15u << 20}; };
  EXPECT_THAT(refusal([&] { SessionWriter w(folder / "s.h5", some_header(), options); }),
              HasSubstr("s.h5: found a disk with 15 MB left, of 16 MB that a recording needs to begin"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SessionWriter, AFillingDiskIsReportedWhileEntriesStillFit) {
  TemporaryFolder folder;
  Disk disk;
  SessionWriter writer(folder / "s.h5", some_header(), disk.options);
  const auto ticks = random_ticks(2700, 30);
  const auto record = [&](std::size_t first, std::uint64_t room) {
    disk.free = room;
    writer.append(std::span(ticks).subspan(first, 900));
    writer.flush();
  };
  record(0, 1u << 30);
  EXPECT_EQ(writer.status().state, WriterStatus::State::kRecording);
  record(900, 40u << 20);
  EXPECT_EQ(writer.status().state, WriterStatus::State::kDiskLow);
  EXPECT_THAT(writer.status().message, HasSubstr("only 40 MB are left"));
  record(1800, 5u << 20);
  EXPECT_EQ(writer.status().state, WriterStatus::State::kDiskLow);
  EXPECT_EQ(writer.status().ticks, 2700u);
  EXPECT_FALSE(writer.status().lost.any());
  EXPECT_TRUE(writer.finish({}));
}

TEST(SessionWriter, WhenTheDiskHasRoomAgainItGoesOnAndTheGapIsAnEvent) {
  TemporaryFolder folder;
  Disk disk;
  // number of ticks that are written together: nine tenths of half a second at 1 kHz
  constexpr std::size_t kChunk = 450;
  const auto ticks = random_ticks(3 * kChunk, 30);
  {
    SessionWriter writer(folder / "s.h5", some_header(), disk.options);
    writer.append(std::span(ticks).first(kChunk));
    disk.free = 1000;
    writer.append(std::span(ticks).subspan(kChunk, kChunk));
    EXPECT_EQ(writer.status().state, WriterStatus::State::kDiskFull);
    disk.free = 1u << 30;
    writer.append(std::span(ticks).subspan(2 * kChunk, kChunk));
    EXPECT_EQ(writer.status().state, WriterStatus::State::kRecording);
    EXPECT_FALSE(writer.finish({})) << "something is missing, and it says so";
  }
  const SessionReader reader(folder / "s.h5");
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.gaps(), (std::vector<Gap>{{ticks[kChunk - 1].t, ticks[2 * kChunk].t, kChunk - 1, kChunk, 0}}));
  EXPECT_EQ(in_words(reader.gaps()), "0.449 s to 0.900 s (450 ticks, 0 cuts)");
  EXPECT_EQ(reader.lost().ticks_disk, kChunk);
  ASSERT_EQ(reader.tick_count(), 2 * kChunk);
  EXPECT_EQ(reader.ticks(kChunk, 1)[0].index, 2 * kChunk) << "the gap shows in the index";
  ASSERT_EQ(reader.events().size(), 1u);
  EXPECT_EQ(reader.events()[0].kind, EventKind::kFault);
  EXPECT_EQ(reader.events()[0].text, "{\"fault\": \"disk_full\", \"rows_lost\": 450}");
}

/// A disk may be full to the last byte, so that every write fails. A limit of the file size stands for such a disk.
TEST(SessionWriter, OnADiskWithoutASingleFreeByteItWaitsForRoom) {
  TemporaryFolder folder;
  Disk disk;
  const auto ticks = random_ticks(1000, 31);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    SessionWriter writer(folder / "s.h5", some_header(), disk.options);
    writer.append(std::span(ticks).first(300));
    writer.flush();
    disk.free = 0;
    const rlimit full{0, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
    for (const std::size_t from : {300, 500}) {
      writer.append(std::span(ticks).subspan(from, 200));
      writer.flush();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(writer.status().state, WriterStatus::State::kDiskFull) << writer.status().message;
    disk.free = 1u << 30;
    writer.append(std::span(ticks).subspan(700));
    writer.flush();
    EXPECT_EQ(writer.status().state, WriterStatus::State::kRecording) << writer.status().message;
    EXPECT_FALSE(writer.finish({}));
  }
  std::signal(SIGXFSZ, old_handler);
  const SessionReader reader(folder / "s.h5");
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.tick_count(), 600u);
  EXPECT_EQ(reader.lost().ticks_disk, 400u);
}

TEST(SessionWriter, PicturesLostToAFullDiskAreCountedAndTheRecordingIsIncomplete) {
  TemporaryFolder folder;
  Disk disk;
  SessionResult result;
  result.pictures = {{"before", "", {1, 2, 3}}, {"after", "", {4, 5}}};
  SessionWriter writer(folder / "s.h5", some_header(), disk.options);
  writer.append(random_ticks(10, 31));
  writer.flush();
  disk.free = 1000;
  EXPECT_FALSE(writer.finish(result));
  EXPECT_FALSE(writer.finish(result)) << "asked again";
  EXPECT_THAT(writer.status().message, HasSubstr("lacks 2 pictures"));
  const SessionReader reader(folder / "s.h5");
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.lost(), Lost{.pictures_disk = 2});
  EXPECT_EQ(reader.tick_count(), 10u);
  EXPECT_TRUE(reader.result()->pictures.empty());
}

TEST(Hash, FilesAndForcesHaveTheKnownSha256AndFnv1aValues) {
  Fnv1a empty, a, foobar;
  a.bytes("a", 1);
  foobar.bytes("foobar", 6);
  // Test vectors of draft-eastlake-fnv.
  EXPECT_EQ(to_text(empty), "fnv1a64:cbf29ce484222325");
  EXPECT_EQ(to_text(a), "fnv1a64:af63dc4c8601ec8c");
  EXPECT_EQ(to_text(foobar), "fnv1a64:85944171f73967e8");
  TemporaryFolder folder;
  std::ofstream(folder / "f") << "foobar";
  std::ostringstream copy;
  const SourceFile file = describe_file(folder / "f", &copy);
  EXPECT_EQ(file.hash, "sha256:c3ab8ff13720e8ad9047dd39466b3c8974e592c2fa383d4a3960714caef0c4f2");
  EXPECT_EQ(file.bytes, 6u);
  EXPECT_EQ(file.path, "f") << "without its folder";
  EXPECT_EQ(copy.str(), "foobar");
  Sha256 parts, whole_text;
  parts.bytes("foo", 3);
  EXPECT_NE(parts.text(), file.hash);
  parts.bytes("bar", 3);
  EXPECT_EQ(parts.text(), file.hash) << "text() does not end it";
  whole_text.bytes("foobar", 6);
  EXPECT_EQ(cache::hash_of(folder / "f"), whole_text.key());

  auto ticks = random_ticks(100, 10);
  Fnv1a whole, pieces, other;
  add_forces(whole, ticks);
  add_forces(pieces, std::span(ticks).first(33));
  add_forces(pieces, std::span(ticks).subspan(33));
  EXPECT_EQ(whole.value, pieces.value);
  ticks[50].f_T_W.y = std::nextafter(ticks[50].f_T_W.y, 100.0);
  add_forces(other, ticks);
  EXPECT_NE(whole.value, other.value);
}

TEST_F(SessionFile, AWriterThatEndsWithoutFinishLeavesATruncatedSessionWithEverythingInIt) {
  const auto ticks = random_ticks(777, 6);
  {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(ticks);
  }
  const SessionReader reader(folder / "s.h5");
  EXPECT_TRUE(reader.truncated());
  EXPECT_FALSE(reader.result());
  ASSERT_EQ(reader.tick_count(), ticks.size());
  EXPECT_TRUE(same_for_replay(reader.ticks()[776], ticks[776]));
}

}  // namespace
}  // namespace typodont::session
