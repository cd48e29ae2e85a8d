// Texts that are drawn over the picture of a session. Three spaces separate parts that may be drawn on different lines.
#include "engine/session/page/catalogue.h"

namespace typodont::session {

namespace {

constexpr Entry kHud[] = {
    {"hud.rpm", {"{} rpm", "{} U/min", "{} 转/分"}},
    {"hud.krpm", {"{} krpm", "{}.000 U/min", "{} 千转/分"}},
    {"hud.stopped",
     {"STOPPED: no drill, no force", "GESTOPPT: kein Bohrer, keine Kraft", "已停止：钻头不转，无力反馈"}},
    {"hud.continue", {"R: continue", "R: weiter", "R：继续"}},
    {"hud.stop", {"space or Esc: stop", "Leertaste oder Esc: Stopp", "空格或 Esc：停止"}},
    {"hud.hand_gone",
     {"The hand's device is disconnected. Plug it in again.",
      "Das Gerät der Hand ist getrennt. Schließen Sie es wieder an.", "手部设备已断开，请重新连接。"}},
    {"hud.stuck",
     {"The tool is stuck in the tooth, {} mm from the hand. Move the hand back to the tool, then out along the path by "
      "which it went in.",
      "Das Werkzeug steckt im Zahn fest, {} mm von der Hand. Führen Sie die Hand zum Werkzeug zurück und dann auf dem "
      "Weg hinaus, auf dem es hineinkam.",
      "器械卡在牙中，距手 {} mm。请将手移回器械处，再沿进入路径退出。"}},
    {"hud.undo", {"Z, Y: undo, redo", "Z, Y: rückgängig, wiederholen", "Z、Y：撤销、重做"}},
    {"hud.view", {"V: view", "V: Ansicht", "V：视图"}},
    {"hud.suction", {"A: suction", "A: Absaugung", "A：吸引"}},
    {"hud.water", {"W: water", "W: Wasser", "W：喷水"}},
    {"hud.tools", {"1–{}: tools", "1–{}: Werkzeuge", "1–{}：器械"}},
    {"hud.implant_keys",
     {"T: instrument   , .: speed   B: backwards", "T: Instrument   , .: Drehzahl   B: rückwärts",
      "T：器械   , .：转速   B：反转"}},
    {"hud.mouse",
     {"left button: drill   wheel: in and out by {} mm (Page up, down)   right button: tilt, middle: upright",
      "linke Taste: bohren   Rad: {} mm hinein und heraus (Bild auf, ab)   rechte Taste: neigen, mittlere: aufrichten",
      "左键：钻削   滚轮：进退 {} mm（Page Up、Page Down）   右键：倾斜，中键：直立"}},
    {"hud.no_record", {"NOTHING MORE IS RECORDED", "ES WIRD NICHTS MEHR AUFGEZEICHNET", "已停止记录！"}},
    {"hud.disk_low", {"THE DISK IS ALMOST FULL", "DER DATENTRÄGER IST FAST VOLL", "磁盘将满！"}},
    {"hud.gaps", {"THE RECORDING HAS GAPS", "DIE AUFZEICHNUNG HAT LÜCKEN", "记录有缺失！"}},
    {"hud.motors", {"motors {} %, up to {} N", "Motoren {} %, bis {} N", "电机 {} %，最大 {} N"}},
    {"hud.not_armed",
     {"no force until the hand is free", "keine Kraft, bis die Hand frei ist", "手离开组织后才有力反馈"}},
    {"hud.suction_on", {"suction on", "Absaugung an", "吸引已开"}},
    {"hud.water_off", {"water off", "Wasser aus", "喷水已关"}},
    {"hud.quality", {"picture: {}", "Bild: {}", "画质：{}"}},
    {"hud.phases_done", {"All phases are done.", "Alle Phasen sind abgeschlossen.", "所有步骤均已完成。"}},
    {"hud.phase_depth", {"{} of {} mm, {} {}", "{} von {} mm, {} {}", "{} / {} mm，{} {}"}},
    {"hud.backwards", {"backwards", "rückwärts", "反转"}},
    {"hud.loop", {"loop", "Schleife", "循环"}},
    {"hud.other_law", {"made with another force law", "mit anderem Kraftgesetz aufgenommen", "使用其他力学规则录制"}},
    {"hud.paused", {"paused", "angehalten", "暂停"}},
    {"hud.exploring", {"exploring, the drill is off", "Tasten, der Bohrer steht", "探查，钻头不转"}},
    {"hud.removing", {"removing caries", "Karies wird entfernt", "正在去除龋坏"}},
    {"hud.caries_left", {"done: {} % of the caries left", "fertig: {} % der Karies übrig", "完成：剩余龋坏 {} %"}},
    {"hud.lift", {"Lift the tool off the tissue.", "Heben Sie das Werkzeug vom Gewebe ab.", "请将器械抬离组织。"}},
    {"hud.feel_first", {"Trial {}: feel the FIRST", "Versuch {}: Fühlen Sie das ERSTE", "第 {} 次：请感受第一个"}},
    {"hud.feel_second", {"Trial {}: feel the SECOND", "Versuch {}: Fühlen Sie das ZWEITE", "第 {} 次：请感受第二个"}},
    {"hud.answer",
     {"left arrow, or 1 and Enter: the first   right arrow, or 2 and Enter: the second",
      "Pfeil links, oder 1 und Eingabetaste: das erste   Pfeil rechts, oder 2 und Eingabetaste: das zweite",
      "左箭头，或 1 加回车：第一个   右箭头，或 2 加回车：第二个"}},
    {"hud.which.stiffness", {"Which was stiffer?", "Was war steifer?", "哪一个更硬？"}},
    {"hud.which.force", {"Which was stronger?", "Was war stärker?", "哪一个力更大？"}},
    {"hud.which.delay", {"Where did the force come later?", "Wo kam die Kraft später?", "哪一个的力来得更晚？"}},
    {"hud.which.model", {"Which was stiffer?", "Was war steifer?", "哪一个更硬？"}},
};

}  // namespace

std::span<const Entry> hud_catalogue() noexcept {
  return kHud;
}

}  // namespace typodont::session
