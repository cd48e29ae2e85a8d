// Tests which files may be read, which may be overwritten, and which files remain when the program is ended.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/cache.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/guarded_process.h"
#include "engine/base/input_file.h"
#include "engine/base/interrupt.h"
#include "engine/base/json.h"
#include "engine/base/partial_file.h"
#include "engine/base/progress.h"
#include "engine/base/temporary_folder.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

TEST(FilesBelow, AreThoseOfAllSubfoldersInOrderWithoutHiddenFoldersAndLoops) {
  const test::Folder folder;
  const std::filesystem::path& top = folder.path();
  for (const char* name : {"b/deep", "a", ".hidden"}) std::filesystem::create_directories(top / name);
  for (const char* file : {"z.h5", "b/s.h5", "b/deep/s.h5", "a/s.h5", "a/s.txt", ".hidden/s.h5"})
    std::ofstream(top / file) << "x";
  std::filesystem::create_directory_symlink(top, top / "a/loop");
  std::filesystem::create_directories(top / "folder.h5");
  EXPECT_THAT(files_below(top, ".h5"),
              testing::ElementsAre(top / "a/s.h5", top / "b/deep/s.h5", top / "b/s.h5", top / "z.h5"));
  EXPECT_THAT(files_below(top / "none", ".h5"), testing::IsEmpty());
}

TEST(TemporaryPlace, IsAnotherFolderWhereTmpdirIsMissing) {
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/nowhere/at/all", 1);
  EXPECT_TRUE(std::filesystem::is_directory(TemporaryFolder().path()));
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
}

TEST(CacheFolder, OfARelativeNameIsNotUsed) {
  const auto value = [](const char* name) { return std::string(std::getenv(name) ? std::getenv(name) : ""); };
  const std::string own = value("TYPODONT_CACHE"), users = value("XDG_CACHE_HOME");
  unsetenv("TYPODONT_CACHE");
  setenv("XDG_CACHE_HOME", "somewhere/below", 1);
  EXPECT_TRUE(cache::folder().empty() || cache::folder().is_absolute()) << cache::folder();
  EXPECT_EQ(cache::folder().string().find("somewhere"), std::string::npos);
  if (!own.empty()) setenv("TYPODONT_CACHE", own.c_str(), 1);
  users.empty() ? unsetenv("XDG_CACHE_HOME") : setenv("XDG_CACHE_HOME", users.c_str(), 1);
}

TEST(GuardedProcess, AProgramThatCannotLoadItsLibrariesIsSaidNotToStart) {
  const TemporaryFolder folder;
  const std::filesystem::path reader = folder.path() / "reader";
  std::ofstream(reader) << "#!/bin/sh\nexit 127\n";
  std::filesystem::permissions(reader, std::filesystem::perms::owner_all);
  EXPECT_THAT(test::refusal([&] { run_guarded({reader.string()}); }), testing::HasSubstr("does not start"));
}

TEST(GuardedProcess, AProgramThatMayNotBeRunIsSaidToBeForbidden) {
  const TemporaryFolder folder;
  const std::filesystem::path reader = folder.path() / "reader";
  std::ofstream(reader) << "#!/bin/sh\nexit 0\n";
  setenv("TYPODONT_TEST_READER", reader.c_str(), 1);
  const auto run = [&] {
    run_guarded({companion_program("TYPODONT_TEST_READER", "no-such-reader", "/nowhere", "a reader").string()});
  };
  EXPECT_THAT(test::refusal(run), testing::HasSubstr("Permission denied"));
  std::filesystem::permissions(reader, std::filesystem::perms::owner_all);
  EXPECT_NO_THROW(run());
  unsetenv("TYPODONT_TEST_READER");
}

namespace fs = std::filesystem;
using test::read_text, test::refusal;
using testing::AllOf;
using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  /// Writes as every command does.
  static void put(const fs::path& file, const std::string& text, FileKind kind = FileKind::kText,
                  Over over = Over::kNoInput) {
    write_file_atomically(file, text, kind, over);
  }
  TemporaryFolder own_;
  const fs::path folder = own_.path();
};

class InputFiles : public Files {};
class Outputs : public Files {};

TEST_F(InputFiles, MustBeRegularFiles) {
  const fs::path fifo = folder / "fifo", socket = folder / "socket";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{AF_UNIX, {}};
  socket.string().copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  fs::create_symlink("/dev/zero", folder / "link");
  const std::vector<std::pair<fs::path, const char*>> special = {
      {folder, "a directory"},   {fifo, "a FIFO"},         {socket, "no regular file"},   {"/dev/zero", "a device"},
      {"/dev/full", "a device"}, {"/dev/tty", "a device"}, {folder / "link", "a device"}, {"/dev/urandom", "a device"}};
  for (const auto& [file, found] : special) {
    EXPECT_THAT(refusal([&] { Json::load(file); }), AllOf(HasSubstr(file.string()), HasSubstr(found)));
    EXPECT_THAT(refusal([&] { read_csv(file, {"t_s"}); }), AllOf(HasSubstr(file.string()), HasSubstr(found)));
  }
  ::close(listening);
}

TEST_F(InputFiles, HaveASizeLimit) {
  for (const auto kind : {InputKind::kJson, InputKind::kTable, InputKind::kSession, InputKind::kVolume,
                          InputKind::kScan, InputKind::kMesh, InputKind::kSound, InputKind::kPicture}) {
    const fs::path file = write("large", "");
    fs::resize_file(file, max_input(kind));  // sparse
    EXPECT_EQ(require_input(file, kind), max_input(kind));
    fs::resize_file(file, max_input(kind) + 1);
    EXPECT_THAT(refusal([&] { require_input(file, kind); }), AllOf(HasSubstr("large"), HasSubstr("of at most")));
  }
}

TEST_F(InputFiles, OfOneEndlessLineAreRefusedAtThatLine) {
  const fs::path file = write("long.csv", "t_s\n1\n" + std::string(LineReader::kLongest + 1, '7') + "\n2\n");
  EXPECT_THAT(refusal([&] { read_csv(file, {"t_s"}); }), HasSubstr("long.csv: line 3: found over 65535 characters"));
  LineReader lines(write("even", std::string(LineReader::kLongest, 'x') + "\n\nlast"), InputKind::kTable);
  std::string line;
  for (const std::size_t length : {LineReader::kLongest, std::size_t{0}, std::size_t{4}}) {
    ASSERT_TRUE(lines.next(line));
    EXPECT_EQ(line.size(), length);
  }
  EXPECT_FALSE(lines.next(line));
}

TEST_F(Outputs, NeverReplaceAnInputFileUnderAnyName) {
  remember_inputs();
  const fs::path input = write("scene.json", "{}"), hard = folder / "hard.json", soft = folder / "soft.json";
  Json::load(input);
  fs::create_hard_link(input, hard);
  fs::create_symlink(input, soft);
  const std::size_t before = count();
  for (const fs::path& name : {input, hard, soft, folder / "." / "scene.json"}) {
    EXPECT_THAT(refusal([&] { put(name, "[]", FileKind::kJson); }),
                AllOf(HasSubstr(name.string()), HasSubstr("is read here, too")));
    EXPECT_EQ(read_text(name), "{}");
  }
  EXPECT_EQ(count(), before);
  put(input, "[1]", FileKind::kJson, Over::kItsInput);
  EXPECT_EQ(read_text(input), "[1]");
}

TEST_F(Outputs, MayTakeTheNameOfADeletedInputFile) {
  remember_inputs();
  const fs::path file = write("again.json", "{}");
  Json::load(file);
  fs::remove(file);
  put(file, "[]", FileKind::kJson);
  EXPECT_EQ(read_text(file), "[]");
}

TEST_F(Outputs, ReplaceOnlyFilesOfTheirType) {
  std::string stl(84, '\0');
  const std::vector<std::pair<FileKind, std::string>> samples = {
      {FileKind::kSession, "\x89HDF\r\n\x1a\n rest"},
      {FileKind::kVolume, std::string(" BDV\0\0\0\0 rest", 13)},
      {FileKind::kPicture, "\x89PNG\r\n\x1a\n rest"},
      {FileKind::kGreyPicture, "P5\n1 1\n255\n\x01"},
      {FileKind::kSound, std::string("RIFF\x01\0\0\0WAVE", 12)},
      {FileKind::kFilm, std::string("\0\0\0 ftypisom", 12)},
      {FileKind::kPage, "<!DOCTYPE html><html></html>"},
      {FileKind::kDrawing, "<svg xmlns=''></svg>"},
      {FileKind::kJson, "\n {\"a\": 1}"},
      {FileKind::kTable, "t_s,x_mm\n0,1\n"},
      {FileKind::kPly, "ply\nformat ascii 1.0\n"},
      {FileKind::kDocument, "%PDF-1.5\n%\xB5\xED\n"},
      {FileKind::kLabels, "NRRD0004\ntype: uint8\n\n\x1f\x8b\x08"},
      {FileKind::kLabels,
       std::string(128, '\0') + "DICM\2" + std::string(1, '\0') + "UI 1.2.840.10008.5.1.4.1.1.66.4 "},
      {FileKind::kStl, stl}};
  for (const auto& [kind, own] : samples) {
    for (const auto& [other, bytes] : samples) {
      const fs::path file = write("there", bytes);
      const std::string said = refusal([&, &own_bytes = own, wanted = kind] { put(file, own_bytes, wanted); });
      if (kind == other) {
        EXPECT_EQ(said, "") << name_of(kind);
      } else {
        EXPECT_THAT(said, HasSubstr("a file of another kind")) << name_of(kind) << " over " << name_of(other);
        EXPECT_EQ(read_text(file), bytes);
      }
    }
    const fs::path empty = write("empty", "");
    put(empty, own, kind);
    EXPECT_EQ(read_text(empty), own);
  }
}

TEST_F(Outputs, AMeshReplacesAGltfFileButNoOtherJsonOrBinaryFile) {
  const std::string binary("glTF\2\0\0\0", 8), text = "{\n \"asset\": {\"version\": \"2.0\"}}";
  for (const std::string& there : {binary, text}) {
    const fs::path file = write("mesh.glb", there);
    put(file, binary, FileKind::kObj);
    EXPECT_EQ(read_text(file), binary);
  }
  for (const std::string& there : {std::string("{\"name\": \"asset\"}"), std::string("\x89PNG\r\n\x1a\n")}) {
    const fs::path file = write("other", there);
    EXPECT_THAT(refusal([&] { put(file, binary, FileKind::kObj); }), HasSubstr("a file of another kind"));
    EXPECT_EQ(read_text(file), there);
  }
}

TEST_F(Outputs, GoIntoDevicesWhichStayDevices) {
  for (const char* device : {"/dev/null", "/dev/zero"}) {
    put(device, "bytes");
    struct stat s {};
    ASSERT_EQ(::stat(device, &s), 0);
    EXPECT_TRUE(S_ISCHR(s.st_mode));
  }
  EXPECT_THAT(refusal([] { put("/dev/full", "bytes"); }), HasSubstr("No space left on device"));
}

TEST_F(Outputs, GoIntoFifosWithAReader) {
  const fs::path fifo = folder / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(refusal([&] { put(fifo, "bytes"); }), HasSubstr("a FIFO that nobody reads"));
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  put(fifo, "bytes");
  std::array<char, 16> got{};
  EXPECT_EQ(::read(reader, got.data(), got.size()), 5);
  EXPECT_STREQ(got.data(), "bytes");
  {
    PartialFile partial(fifo);
    ::close(reader);
    EXPECT_THAT(refusal([&] {
                  std::ofstream(partial.path()) << "more";
                  partial.keep();
                }),
                HasSubstr("Broken pipe"));
  }
  EXPECT_TRUE(fs::is_fifo(fifo));
}

TEST_F(Outputs, GoIntoAnOpenDescriptorWithoutReplacingItsFile) {
  const fs::path file = folder / "redirected";
  const int open_file = ::open(file.c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(::write(open_file, "one,", 4), 4);
  put(fmt::format("/dev/fd/{}", open_file), "two,");
  ASSERT_EQ(::write(open_file, "three", 5), 5);
  ::close(open_file);
  EXPECT_EQ(read_text(file), "one,two,three");
}

TEST_F(Outputs, FollowALinkToAFileAndRefuseADanglingLink) {
  fs::create_directory(folder / "far");
  const fs::path file = write("far/file.txt", "old");
  fs::create_symlink("far/file.txt", folder / "link.txt");
  put(folder / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
  EXPECT_EQ(read_text(file), "new");
  EXPECT_FALSE(fs::is_symlink(file));
  const fs::path accounts = write("far/accounts", "root:x:0:0\n");  // plain text, but no table
  fs::create_symlink("far/accounts", folder / "link.csv");
  EXPECT_THAT(refusal([&] { write_file_atomically(folder / "link.csv", "a,b\n", FileKind::kTable); }),
              AllOf(HasSubstr("a link to "), HasSubstr("expected a link to a table (.csv)")));
  EXPECT_EQ(read_text(accounts), "root:x:0:0\n");
  fs::create_symlink("nowhere", folder / "dangling.txt");
  EXPECT_THAT(refusal([&] { put(folder / "dangling.txt", "new"); }), HasSubstr("a link that leads to no file"));
  EXPECT_FALSE(fs::exists(folder / "nowhere"));
}

TEST_F(Outputs, KeepModeAndOwnerOfTheReplacedFile) {
  for (const mode_t mode : {0600u, 0640u, 0644u, 0666u}) {
    const fs::path file = write("secret.txt", "old");
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
    const bool root = ::geteuid() == 0;
    if (root) {
      ASSERT_EQ(::chown(file.c_str(), 4711, 4712), 0);
    }
    {
      const PartialFile half(file);
      struct stat s {};
      ASSERT_EQ(::stat(half.path().c_str(), &s), 0);
      EXPECT_EQ(s.st_mode & 077, 0u) << "nobody else reads what is half written";
    }
    put(file, "new");
    struct stat s {};
    ASSERT_EQ(::stat(file.c_str(), &s), 0);
    EXPECT_EQ(s.st_mode & 07777, mode);
    EXPECT_EQ(s.st_uid, root ? 4711 : ::geteuid());
    if (root) {
      EXPECT_EQ(s.st_gid, 4712u);
    }
  }
}

/// Runs `work` in a child process and returns the child's exit status. The child's messages are discarded.
int status_of(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(STDERR_FILENO);
    work();
    ::_exit(0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(Outputs, DoNotChangeAWriteProtectedFile) {
  const fs::path file = write("kept.txt", "old");
  ASSERT_EQ(::chmod(file.c_str(), 0444), 0);
  ASSERT_EQ(::chmod(folder.c_str(), 0777), 0);
  EXPECT_EQ(status_of([&] {  // as another user than root, who may write to every file
              if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) ::_exit(2);
              ::_exit(refusal([&] { put(file, "new"); }).find("Permission denied") != std::string::npos ? 0 : 1);
            }),
            0);
  EXPECT_EQ(read_text(file), "old");
}

TEST_F(Outputs, HaveUnpredictableNamesWhileIncomplete) {
  const PartialFile a(folder / "x.txt"), b(folder / "x.txt");
  EXPECT_NE(a.path(), b.path());
  EXPECT_EQ(a.path().parent_path(), folder);
  EXPECT_EQ(fs::file_size(a.path()), 0u) << "made, so that nobody else can make it";
}

TEST_F(Outputs, AreDeletedIfASignalEndsTheProgramBeforeTheyAreComplete) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(status_of([&] {
                end_cleanly_on_interrupt();
                const PartialFile one(folder / "one.txt"), two(folder / "two.txt");
                ::raise(signal);
              }),
              1);
    EXPECT_EQ(count(), 0u) << signal;
    EXPECT_EQ(status_of([&] {  // long work is cancelled by the first signal, and ended by the second
                end_cleanly_on_interrupt();
                const PartialFile one(folder / "one.txt");
                Progress work("work");
                ::raise(signal);
                if (!work.cancelled()) ::_exit(3);
                ::raise(signal);
              }),
              1);
    EXPECT_EQ(count(), 0u) << signal;
  }
  EXPECT_EQ(status_of([&] {
              ::signal(SIGHUP, SIG_IGN);  // as nohup does
              end_cleanly_on_interrupt();
              ::raise(SIGHUP);
              const Progress work("work");
              ::raise(SIGHUP);
              ::_exit(work.cancelled() ? 3 : 0);
            }),
            0);
}

TEST(JsonMessages, NameLineAndColumnOfInvalidJson) {
  EXPECT_EQ(refusal([] { Json::parse("{\n\"a\": 1,\n\"b\": nope}", "x.json"); }),
            "x.json: line 3, column 7: found text that is not JSON, expected valid JSON");
  EXPECT_THAT(refusal([] { Json::parse("{\"a\": [1, 2,\n", "x.json"); }), HasSubstr("x.json: line 2, column 1"));
  EXPECT_THAT(refusal([] { Json::parse("", "x.json"); }), HasSubstr("x.json: line 1, column 1"));
  EXPECT_THAT(refusal([] { Json::parse(std::string(100000, '['), "x.json"); }), HasSubstr("nested"));
}

TEST(JsonMessages, NameLineAndKeyOfNumbersOutsideTheRangeOfDouble) {
  EXPECT_EQ(refusal([] { Json::parse("{\"tool\": {\n\"sizes\": [1,\n -1e309]}}", "x.json"); }),
            "x.json: line 3, \"tool.sizes[1]\": found -1e309, expected a number of at most 1.8e308");
}

TEST(JsonMessages, NameLineAndKeyOfEveryWrongValue) {
  const Json json = Json::parse("{\n\"a\": {\n  \"b\": [1,\n 2,\n{\"c\": true}]\n}, \"b\": 7\n}", "x.json");
  EXPECT_THAT(refusal([&] { json["a"]["b"].items()[1].string(); }), HasSubstr("x.json: line 4, \"a.b[1]\": found 2"));
  EXPECT_THAT(refusal([&] { json["a"]["b"].items()[2]["c"].number(); }), HasSubstr("line 5, \"a.b[2].c\": found true"));
  EXPECT_THAT(refusal([&] { json["b"].string(); }), HasSubstr("line 6, \"b\": found 7"));
  EXPECT_THAT(refusal([&] { json["a"]["x"]; }), HasSubstr("line 2, \"a.x\": found nothing"));
  EXPECT_THAT(refusal([&] { json.allow_only({"a"}); }), HasSubstr("line 6, \"b\": found an unknown key"));
  EXPECT_THAT(refusal([] { Json::parse("{\"a\":\n1, \"a\": 2}", "x.json"); }),
              HasSubstr("x.json: line 2, \"a\": found the key twice"));
}

TEST(JsonMessages, NameNoLineForDocumentsBuiltByTheProgram) {
  const Json json = Json::parse("{\n\"a\": 1}", "x.json", Json::Lines::kUnknown);
  EXPECT_EQ(refusal([&] { json["a"].string(); }), "x.json: \"a\": found 1, expected a string");
}

TEST(Messages, AreShortWhateverTheInput) {
  const std::string key(20000, 'k');
  const Json json = Json::parse("{\"" + key + "\": {\"" + key + "\": 1e3}}", "x.json");
  for (const std::string& said :
       {refusal([&] { json.allow_only({"a"}); }), refusal([&] { json[key].allow_only({"a"}); }),
        refusal([&] { json[key][key].string(); }), refusal([&] { Json::parse("{\"" + key + "\": 1e999}", "x.json"); }),
        refusal([&] { Json::parse("{\"" + key + "\": 1, \"" + key + "\": 2}", "x.json"); })}) {
    EXPECT_GT(said.size(), 20u);
    EXPECT_LT(said.size(), 700u);
    EXPECT_THAT(said, HasSubstr("line 1"));
  }
}

TEST(Messages, ContainNoTerminalControlAndNoIncompleteCharacter) {
  EXPECT_EQ(std::string(Error("x", "", "\x1b[2J\nno", "yes").what()), "x: found ?[2J?no, expected yes");
  std::string long_text;
  for (int i = 0; i < 200; ++i) long_text += "ö";
  const std::string said = Error("x", "", long_text, "").what();
  EXPECT_TRUE(said.ends_with("ö...")) << said;
}

}  // namespace
}  // namespace typodont
