// Tests hidraw devices that the program cannot distinguish from real ones. umockdev provides udev, sysfs, /dev and
// ioctls; a live emulation provides the reports. Enumeration, permissions, opening, locking and reports use hidapi and
// calls of the kernel.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/realtime.h"
#include "engine/contract/contact.h"
#include "engine/session/session_file.h"
#include "haptics/devices.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/hid.h"
#include "tests/support/program.h"

namespace typodont::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Returns the testbed into which all devices of a test are plugged. Environment variables give it to libraries and
/// programs in place of the real system.
std::shared_ptr<UMockdevTestbed> testbed() {
  static std::weak_ptr<UMockdevTestbed> current;
  std::shared_ptr<UMockdevTestbed> bed = current.lock();
  if (!bed) {
    bed.reset(umockdev_testbed_new(), [](UMockdevTestbed* b) { g_object_unref(b); });
    current = bed;
  }
  return bed;
}

/// Emulates a hidraw device. Its node is a pseudo-terminal. While reports are queued, one byte waits in the terminal,
/// so that poll() wakes.
class MockHid {
 public:
  MockHid(int number, std::uint16_t vendor, std::uint16_t product, std::string name, std::string serial,
          Bytes descriptor)
      : descriptor_(std::move(descriptor)), shared_(testbed()), bed_(shared_.get()) {
    node_ = fmt_node(number);
    char id[64];
    std::snprintf(id, sizeof id, "0003:%08X:%08X", vendor, product);
    const auto add = [&](const char* subsystem, const std::string& device, const char* parent,
                         std::vector<const char*> attributes, std::vector<const char*> properties) {
      attributes.push_back(nullptr);
      properties.push_back(nullptr);
      gchar* path =
          umockdev_testbed_add_devicev(bed_, subsystem, device.c_str(), parent, const_cast<gchar**>(attributes.data()),
                                       const_cast<gchar**>(properties.data()));
      const std::string out = path ? path : "";
      g_free(path);
      return out;
    };
    char vid[8], pid[8];
    std::snprintf(vid, sizeof vid, "%04x", vendor);
    std::snprintf(pid, sizeof pid, "%04x", product);
    const std::string usb = add("usb", "usb" + std::to_string(number), nullptr,
                                {"idVendor", vid, "idProduct", pid, "manufacturer", "Maker", "product", name.c_str(),
                                 "serial", serial.c_str(), "bcdDevice", "0100", "bInterfaceNumber", "00"},
                                {"DEVTYPE", "usb_device"});
    const std::string interface = add("usb", "usb" + std::to_string(number) + ":1.0", usb.c_str(),
                                      {"bInterfaceNumber", "00"}, {"DEVTYPE", "usb_interface"});
    const std::string hid = add("hid", std::string(id) + ".0001", interface.c_str(), {},
                                {"HID_ID", id, "HID_NAME", name.c_str(), "HID_UNIQ", serial.c_str(), "HID_PHYS", ""});
    umockdev_testbed_set_attribute_binary(bed_, hid.c_str(), "report_descriptor", descriptor_.data(),
                                          static_cast<gint>(descriptor_.size()));
    const std::string uevent = std::string("HID_ID=") + id + "\nHID_NAME=" + name + "\nHID_UNIQ=" + serial + "\n";
    umockdev_testbed_set_attribute(bed_, hid.c_str(), "uevent", uevent.c_str());
    // umockdev makes a device node only from a textual record. The node is a character device: a pseudo-terminal.
    const std::string name_in_dev = node_.substr(5);
    const std::string record =
        "P: " + hid.substr(4) + "/hidraw/" + name_in_dev + "\nN: " + name_in_dev + "\nE: DEVNAME=" + node_ +
        "\nE: MAJOR=240\nE: MINOR=0\nE: SUBSYSTEM=hidraw\nA: dev=240:0\nL: device=../../../" + id + ".0001\n";
    GError* error = nullptr;
    EXPECT_TRUE(umockdev_testbed_add_from_string(bed_, record.c_str(), &error)) << (error ? error->message : "");

    handler_ = umockdev_ioctl_base_new();
    g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&MockHid::on_ioctl), this);
    g_signal_connect(handler_, "handle-read", G_CALLBACK(&MockHid::on_read), this);
    g_signal_connect(handler_, "handle-write", G_CALLBACK(&MockHid::on_write), this);
    EXPECT_TRUE(umockdev_testbed_attach_ioctl(bed_, node_.c_str(), handler_, &error)) << (error ? error->message : "");
  }
  virtual ~MockHid() {
    umockdev_testbed_detach_ioctl(bed_, node_.c_str(), nullptr);
    g_object_unref(handler_);
  }

  void send(Bytes report) {
    const std::scoped_lock lock(mutex_);
    reports_.push_back(std::move(report));
    if (reports_.size() == 1) wake();
  }
  void unplug() {
    const std::scoped_lock lock(mutex_);
    gone_ = true;
    wake();
  }
  /// Only root may open the device, but every user may see that it exists.
  void forbid() {
    gchar* name = umockdev_testbed_get_root_dir(bed_);
    const std::string root = name;
    g_free(name);
    ::chmod(root.c_str(), 0755);
    ::chmod((root + node_).c_str(), 0);
  }

 protected:
  virtual void written(const Bytes&) {}

 private:
  static std::string fmt_node(int number) { return "/dev/hidraw" + std::to_string(number); }

  void wake() { [[maybe_unused]] const auto n = ::write(umockdev_testbed_get_dev_fd(bed_, node_.c_str()), "!", 1); }
  void sleep() { ::tcflush(umockdev_testbed_get_dev_fd(bed_, node_.c_str()), TCIOFLUSH); }

  /// Gives the calling thread of umockdev, which answers for all devices, a real-time priority. Otherwise, on a busy
  /// machine, the servo would wait for the answer of a device for so long that the program rightly stops the drill.
  static void answer_in_time() {
    [[maybe_unused]] thread_local const RealtimeGranted granted =
        enter_realtime({.priority = 82, .core = -1, .lock_memory = false});
  }

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, MockHid* self) {
    answer_in_time();
    const gulong request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData* arg = umockdev_ioctl_client_get_arg(client);
    if (request == HIDIOCGRDESCSIZE) {
      UMockdevIoctlData* data = umockdev_ioctl_data_resolve(arg, 0, sizeof(int), nullptr);
      const int size = static_cast<int>(self->descriptor_.size());
      std::memcpy(data->data, &size, sizeof size);
      umockdev_ioctl_client_complete(client, 0, 0);
      g_object_unref(data);
      return TRUE;
    }
    if (request == HIDIOCGRDESC) {
      UMockdevIoctlData* data = umockdev_ioctl_data_resolve(arg, 0, sizeof(hidraw_report_descriptor), nullptr);
      auto* out = reinterpret_cast<hidraw_report_descriptor*>(data->data);
      out->size = static_cast<unsigned>(self->descriptor_.size());
      std::memcpy(out->value, self->descriptor_.data(), self->descriptor_.size());
      umockdev_ioctl_client_complete(client, 0, 0);
      g_object_unref(data);
      return TRUE;
    }
    umockdev_ioctl_client_complete(client, -1, ENOTTY);
    return TRUE;
  }

  static gboolean on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, MockHid* self) {
    answer_in_time();
    UMockdevIoctlData* arg = umockdev_ioctl_client_get_arg(client);
    Bytes report;
    {
      const std::scoped_lock lock(self->mutex_);
      if (self->gone_) {
        umockdev_ioctl_client_complete(client, -1, ENODEV);
        return TRUE;
      }
      if (self->reports_.empty()) {
        umockdev_ioctl_client_complete(client, -1, EAGAIN);
        return TRUE;
      }
      report = self->reports_.front();
      self->reports_.pop_front();
      if (self->reports_.empty()) self->sleep();
    }
    const auto n = std::min<std::size_t>(report.size(), static_cast<std::size_t>(arg->data_len));
    umockdev_ioctl_data_update(arg, 0, report.data(), static_cast<gint>(n));
    umockdev_ioctl_client_complete(client, static_cast<glong>(n), 0);
    return TRUE;
  }

  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, MockHid* self) {
    answer_in_time();
    UMockdevIoctlData* arg = umockdev_ioctl_client_get_arg(client);
    const Bytes bytes(arg->data, arg->data + arg->data_len);
    umockdev_ioctl_client_complete(client, static_cast<glong>(bytes.size()), 0);
    self->written(bytes);
    return TRUE;
  }

  Bytes descriptor_;
  std::shared_ptr<UMockdevTestbed> shared_;
  UMockdevTestbed* bed_;
  UMockdevIoctlBase* handler_;
  std::string node_;
  std::mutex mutex_;
  std::deque<Bytes> reports_;
  bool gone_ = false;
};

/// HID descriptor of a multi-axis controller, only as long as enumeration needs it.
const Bytes kSpaceMouseDescriptor{0x05, 0x01, 0x09, 0x08, 0xa1, 0x01, 0xc0};
const Bytes kArmDescriptor{0x06, 0xab, 0xff, 0x0a, 0x00, 0x02, 0xa1, 0x01, 0xc0};

TEST(Umockdev, AnArmIsFoundOpenedUsedAndLost) {
  struct Board : MockHid {
    Board() : MockHid(1, 0x1234, 0x0006, "WoodenHaptics", "WH-7", kArmDescriptor) {}
    void written(const Bytes& bytes) override {
      if (bytes.size() != 9) return;  // a board of the first generation
      last = static_cast<std::int16_t>(bytes[1] | bytes[2] << 8);
      ++writes;
      send({0, 0, 0, 0, 0, 0, 0, 0});
    }
    std::atomic<int> writes{0}, last{0};
  } board;

  const auto found = list_devices();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].address, "woodenhaptics:WH-7");
  EXPECT_EQ(found[0].force_limit, 5);

  HandOptions options;
  options.assets = "assets";
  auto hand = open_hand("woodenhaptics:WH-7", options);
  EXPECT_EQ(hand->info().serial, "WH-7");
  EXPECT_THROW(open_hand("woodenhaptics:", options), Error);  // held
  HandSample sample;
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(hand->read(sample));
    hand->write(dvec3(0), dvec3(0));
  }
  EXPECT_NEAR(sample.X_WT.p.x, 0.025, 1e-6);
  EXPECT_GE(board.writes, 300);
  board.unplug();
  bool alive = true;
  for (int i = 0; i < 20 && alive; ++i) {
    alive = hand->read(sample);
    hand->write(dvec3(0), dvec3(0));
  }
  EXPECT_FALSE(alive);
}

const Bytes kKeyboardDescriptor{0x05, 0x01, 0x09, 0x06, 0xa1, 0x01, 0xc0};
/// HID descriptor of a report with the number 3: two buttons, and two axes of 12 bits, which are the accelerator and
/// the brake of the simulation page.
const Bytes kRheostatDescriptor{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01,
                                0x29, 0x02, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x02, 0x81, 0x02,
                                0x75, 0x06, 0x95, 0x01, 0x81, 0x03, 0x05, 0x02, 0x09, 0xc4, 0x09, 0xc5,
                                0x15, 0x00, 0x26, 0xff, 0x0f, 0x75, 0x0c, 0x95, 0x02, 0x81, 0x02, 0xc0};

/// Runs `typodont run` with emulated devices that it finds by itself, and reads what it recorded.
class WholeProgram : public testing::Test {
 protected:
  WholeProgram() : folder(TYPODONT_PROGRAM) {
    folder.write("scene.json", R"({"name": "block", "tissue": {"voxel_mm": 0.5, "solids": [
      {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, -100], "size_mm": [10, 10, 8]}}}]},
      "tool": {"shape": "sphere", "diameter_mm": 2}, "spindle_krpm": 40, "parts": ["haptics"]})");
  }
  ~WholeProgram() override {
    if (child > 0) folder.finish(child, SIGKILL);
  }
  /// Returns when it runs and records.
  void start(const std::string& rig, const std::string& options) {
    folder.write("rig.json", rig);
    child = folder.start(fmt::format("run {} --rig {} --audio none: --no-real-time --record {} --json {}",
                                     folder / "scene.json", folder / "rig.json", folder / "s.h5", options));
    test::GrowingFile recording(folder / "s.h5");
    const auto ended = [&] { return ::waitpid(child, nullptr, WNOHANG) == child; };
    bool records = false;
    for (int i = 0; i < 6000 && !(records = recording.has_grown()); ++i) {
      ::usleep(10'000);
      if (ended()) {
        child = -1;
        FAIL() << folder.said();
      }
    }
    ASSERT_TRUE(records) << folder.said();
  }
  Json end() {
    const test::Ran ran = folder.finish(child);
    child = -1;
    EXPECT_EQ(ran.status, 0) << ran.err;
    ticks = session::SessionReader(folder / "s.h5").ticks();
    return Json::parse(ran.out, "what run printed");
  }

  test::ProgramFolder folder;
  pid_t child = -1;
  std::vector<ServoTick> ticks;
};

TEST_F(WholeProgram, ListsEveryDeviceWithModelSerialAndPermission) {
  MockHid mouse(0, 0x046d, 0xc626, "SpaceNavigator", "SN-5", kSpaceMouseDescriptor);
  MockHid arm(1, 0x1234, 0x0006, "WoodenHaptics", "WH-7", kArmDescriptor);
  MockHid foot(2, 0x0c45, 0x7403, "FootSwitch", "FS-1", kKeyboardDescriptor);
  MockHid rheostat(3, 0x1111, 0x2222, "Rheostat", "RH-9", kRheostatDescriptor);
  const test::Ran ran = expect_ok(folder.run("devices --json"));
  const Json found = Json::parse(ran.out, "devices");
  std::map<std::string, std::string> kinds;
  for (const Json& device : found["devices"].items()) {
    kinds[device["model"].string() + " " + device["serial"].string()] = device["kind"].string();
    EXPECT_TRUE(device["permitted"].boolean());
  }
  const std::map<std::string, std::string> expected{{"SpaceNavigator SN-5", "6-DoF mouse"},
                                                    {"WoodenHaptics WH-7", "force feedback"},
                                                    {"FootSwitch FS-1", "foot switch"},
                                                    {"Rheostat RH-9", "rheostat pedal"}};
  EXPECT_EQ(kinds, expected);
}

TEST_F(WholeProgram, ADeviceWithoutPermissionIsListedWithTheCommandThatGrantsIt) {
  MockHid mouse(0, 0x046d, 0xc626, "SpaceNavigator", "SN-5", kSpaceMouseDescriptor);
  MockHid arm(1, 0x1234, 0x0006, "WoodenHaptics", "WH-7", kArmDescriptor);
  MockHid foot(2, 0x0c45, 0x7403, "FootSwitch", "FS-1", kKeyboardDescriptor);
  for (MockHid* device : {&mouse, &arm, &foot}) device->forbid();
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const std::string user = ::geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups" : "";
  const test::Ran listed = expect_ok(folder.run("devices --json", user));
  const Json found = Json::parse(listed.out, "devices");
  ASSERT_EQ(found["devices"].items().size(), 3u) << listed.out;
  for (const Json& device : found["devices"].items()) {
    EXPECT_FALSE(device["permitted"].boolean()) << device["model"].string();
    EXPECT_NE(device["mend"].string().find("sudo typodont devices --install-udev"), std::string::npos);
  }
}

TEST_F(WholeProgram, AFootSwitchDrillsUntilItIsStuckWhileASpaceMouseSteersByRate) {
  MockHid mouse(0, 0x046d, 0xc626, "SpaceNavigator", "SN-5", kSpaceMouseDescriptor);
  MockHid foot(2, 0x0c45, 0x7403, "FootSwitch", "FS-1", kKeyboardDescriptor);
  const auto step_on = [&](bool down) { foot.send({0, 0, static_cast<std::uint8_t>(down ? 4 : 0), 0, 0, 0, 0, 0}); };
  start(R"({"display": "offscreen", "hand": "spacemouse:SN-5", "pedal": "FS-1", "pedal_limit_s": 1.5})", "");
  for (int i = 0; i < 50; ++i) {  // a deflected cap repeats itself
    mouse.send({1, 0x5e, 0x01, 0, 0, 0, 0});
    ::usleep(20'000);
  }
  step_on(true);
  ::usleep(3'500'000);
  step_on(false);
  ::usleep(500'000);
  step_on(true);
  ::usleep(500'000);
  const std::string safety = end()["safety"].string();
  EXPECT_NE(safety.find("pedal stuck"), std::string::npos) << safety;
  // The pedal must be up; then down for as long as the rig allows; then off while the foot stays on it; then down again
  // after it was up.
  std::vector<std::pair<double, double>> stretches;  // pedal, s
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    if (stretches.empty() || stretches.back().first != ticks[i].pedal) stretches.push_back({ticks[i].pedal, 0});
    stretches.back().second += to_seconds(ticks[i].t - ticks[i - 1].t);
  }
  ASSERT_EQ(stretches.size(), 4u);
  EXPECT_EQ(stretches[1].first, 1);
  EXPECT_NEAR(stretches[1].second, 1.5, 0.005);
  EXPECT_GT(stretches[2].second, 1);
  EXPECT_EQ(stretches[3].first, 1);
  EXPECT_GT(ticks.back().X_WT.p.x, 0.01);  // steered there at 50 mm/s, and stayed
}

TEST_F(WholeProgram, ARheostatModulatesTheDrillAndASpaceMouseSteersByPosition) {
  MockHid mouse(0, 0x046d, 0xc626, "SpaceNavigator", "SN-5", kSpaceMouseDescriptor);
  MockHid rheostat(3, 0x1111, 0x2222, "Rheostat", "RH-9", kRheostatDescriptor);
  start(R"({"display": "offscreen", "hand": "spacemouse:SN-5,position"})", "--pedal auto");
  for (int i = 0; i < 80; ++i) {
    mouse.send({1, 0x5e, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    ::usleep(20'000);
    // Presses the pedal half-way after the session has started, because a pedal that is down at the start does not
    // start the drill.
    if (i == 40) rheostat.send({3, 0, 0x00, 0x08, 0x00});
  }
  double farthest = 0;
  end();
  for (const ServoTick& tick : ticks) farthest = std::max(farthest, tick.X_WT.p.x);
  EXPECT_NEAR(farthest, 0.03, 1e-4);  // the cap's full deflection is 30 mm, however long it is held
  EXPECT_NEAR(ticks.back().pedal, 0.5, 1e-3);
  EXPECT_GT(ticks.back().spindle, 0);
}

}  // namespace
}  // namespace typodont::haptics
