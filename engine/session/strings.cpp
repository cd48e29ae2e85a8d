#include "engine/session/strings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "engine/session/page/catalogue.h"
#include "engine/session/score.h"

namespace typodont::session {

namespace {

constexpr Entry kCatalogue[] = {
    {"title", {"Session report", "Sitzungsbericht", "训练报告"}},
    {"title.curve", {"Learning curve", "Lernkurve", "学习曲线"}},
    {"sessions_count", {"Sessions: {}", "Sitzungen: {}", "训练次数：{}"}},
    {"curve_alt",
     {"{}, session by session: first {}, last {}.", "{}, Sitzung für Sitzung: zuerst {}, zuletzt {}.",
      "{}逐次变化：首次 {}，最近 {}。"}},
    {"cut_off", {"cut off", "abgebrochen", "中断"}},
    {"skip", {"Skip to the result", "Zum Ergebnis springen", "跳到结果"}},
    {"contents", {"Contents", "Inhalt", "目录"}},
    {"result", {"Result", "Ergebnis", "结果"}},
    {"score", {"Score", "Punktzahl", "得分"}},
    {"points_of", {"{} of {} points", "{} von {} Punkten", "{} 分（满分 {} 分）"}},
    {"points_sum", {"Sum of the items", "Summe der Posten", "各项合计"}},
    {"passed", {"Passed", "Bestanden", "合格"}},
    {"not_passed", {"Not passed", "Nicht bestanden", "不合格"}},
    {"below_pass", {"below the pass mark", "unter der Bestehensgrenze", "低于合格线"}},
    {"pass_mark", {"Pass mark: {} ({})", "Bestehensgrenze: {} ({})", "合格线：{} 分（{}）"}},
    {"technical", {"Timing and files", "Zeitverhalten und Dateien", "时序与文件"}},
    {"back_to_result", {"Back to the result", "Zurück zum Ergebnis", "返回结果"}},
    {"completion", {"Share of the task done", "Anteil der erledigten Aufgabe", "任务完成比例"}},
    {"items_note",
     {"All items together have 100 points. Their sum counts in proportion to the share of the task that was done: "
      "doing "
      "nothing, however carefully, earns nothing. One tolerance beyond the target leaves half of an item's points, two "
      "leave a third. Red with a cross: a smaller share than the pass mark.",
      "Alle Posten zusammen haben 100 Punkte. Ihre Summe zählt im Verhältnis zum erledigten Anteil der Aufgabe: Nichts "
      "zu tun, und sei es noch so sorgfältig, bringt keine Punkte. Eine Toleranz jenseits des Ziels lässt die Hälfte "
      "der "
      "Punkte eines Postens, zwei lassen ein Drittel. Rot mit Kreuz: ein kleinerer Anteil als die Bestehensgrenze.",
      "各项满分合计 100 "
      "分，其总和按任务完成比例折算：什么都不做，再小心也不得分。超出目标一个容差，该项得一半分；超出两"
      "个容差，得三分之一。红色并带叉号：得分比例低于合格线。"}},
    {"items", {"Score, item by item", "Bewertung im Einzelnen", "逐项评分"}},
    {"item", {"Item", "Posten", "项目"}},
    {"value", {"Value", "Wert", "数值"}},
    {"target", {"Target", "Ziel", "目标"}},
    {"tolerance", {"Tolerance", "Toleranz", "容差"}},
    {"points", {"Points", "Punkte", "得分"}},
    {"source", {"Source", "Quelle", "依据"}},
    {"guarantee", {"Guaranteed by", "Gewährleistet durch", "核对方式"}},
    {"guarantee.replay", {"replay of tissue and forces", "Wiederholung von Gewebe und Kräften", "重放组织与力"}},
    {"guarantee.ticks",
     {"replay, number of ticks and servo rate", "Wiederholung, Zahl der Takte und Taktrate", "重放、节拍数与伺服频率"}},
    {"guarantee.hand",
     {"nothing but a signature: the recorded hand", "nur durch eine Signatur: die aufgezeichnete Hand",
      "仅签名：所记录的手部运动"}},
    {"guarantee.none", {"nothing: no replay", "nichts: keine Wiederholung", "无：未重放"}},
    {"not_counted", {"not counted", "ohne Wertung", "不计分"}},
    {"at_most", {"at most {}", "höchstens {}", "不超过 {}"}},
    {"at_least", {"at least {}", "mindestens {}", "不低于 {}"}},
    {"near", {"{}", "{}", "{}"}},
    {"pictures", {"Pictures", "Bilder", "图片"}},
    {"picture.before", {"Before", "Vorher", "操作前"}},
    {"picture.during", {"During", "Währenddessen", "操作中"}},
    {"picture.after", {"After", "Nachher", "操作后"}},
    {"picture.alt", {"Picture of the tissue: {}", "Bild des Gewebes: {}", "组织图片：{}"}},
    {"task", {"Task", "Aufgabe", "任务"}},
    {"form", {"Shape of the result", "Form des Ergebnisses", "结果形态"}},
    {"form_note",
     {"Compared with the ideal: red where it was cut too deep, blue where too much is left.",
      "Verglichen mit dem Ideal: rot, wo zu tief, blau, wo zu wenig abgetragen wurde.",
      "与理想形态比较：红色表示切得过深，蓝色表示残留过多。"}},
    {"difference", {"Difference from the ideal", "Abweichung vom Ideal", "与理想形态的差异"}},
    {"too_deep", {"too deep", "zu tief", "过深"}},
    {"too_much", {"too much left", "zu viel übrig", "残留过多"}},
    {"colorbar_alt",
     {"Colours of the difference: red half a millimetre too deep, grey as it should be, blue half a millimetre too "
      "much left.",
      "Farben der Abweichung: rot einen halben Millimeter zu tief, grau wie es sein soll, blau einen halben Millimeter "
      "zu viel.",
      "差异颜色：红色为过深半毫米，灰色为正确，蓝色为残留半毫米。"}},
    {"worst_over",
     {"Cut too deep: greatest depth {}, {}.", "Zu tief abgetragen: größte Tiefe {}, {}.", "最大过切 {}：{}。"}},
    {"worst_under",
     {"Too much left: greatest thickness {}, {}.", "Zu viel übrig: größte Dicke {}, {}.", "最大残留 {}：{}。"}},
    {"place.coordinates", {"at x {}, y {}, z {} mm", "bei x {}, y {}, z {} mm", "位置 x {}、y {}、z {} mm"}},
    {"place.part_and_side", {"{side} {part}", "{part}, {side}", "{side}{part}"}},
    {"place.and_third", {"{}, {}", "{}, {}", "{}，{}"}},
    {"place.part.floor", {"floor", "Boden", "洞底"}},
    {"place.part.wall", {"wall", "Wand", "洞壁"}},
    {"place.part.occlusal", {"occlusal surface", "Okklusalfläche", "咬合面"}},
    {"place.part.axial", {"axial wall", "axiale Wand", "轴壁"}},
    {"place.part.shoulder", {"shoulder", "Stufe", "肩台"}},
    {"place.side.mesial", {"mesial", "mesial", "近中"}},
    {"place.side.mesiobuccal", {"mesiobuccal", "mesiobukkal", "近中颊侧"}},
    {"place.side.buccal", {"buccal", "bukkal", "颊侧"}},
    {"place.side.distobuccal", {"distobuccal", "distobukkal", "远中颊侧"}},
    {"place.side.distal", {"distal", "distal", "远中"}},
    {"place.side.distolingual", {"distolingual", "distolingual", "远中舌侧"}},
    {"place.side.lingual", {"lingual", "lingual", "舌侧"}},
    {"place.side.mesiolingual", {"mesiolingual", "mesiolingual", "近中舌侧"}},
    {"place.side.central", {"central", "zentral", "中央"}},
    {"place.third.occlusal", {"occlusal third", "okklusales Drittel", "咬合侧三分之一"}},
    {"place.third.middle", {"middle third", "mittleres Drittel", "中三分之一"}},
    {"place.third.cervical", {"cervical third", "zervikales Drittel", "颈侧三分之一"}},
    {"view", {"View", "Ansicht", "视图"}},
    {"view.above", {"From above", "Von oben", "俯视"}},
    {"view.front", {"From the front", "Von vorn", "正面"}},
    {"view.side", {"From the side", "Von der Seite", "侧面"}},
    {"view.angled", {"At an angle", "Schräg", "斜视"}},
    {"view.occlusal", {"Occlusal view", "Okklusalansicht", "咬合面观"}},
    {"view.mesial", {"Mesial view", "Mesialansicht", "近中面观"}},
    {"view.distal", {"Distal view", "Distalansicht", "远中面观"}},
    {"view.buccal", {"Buccal view", "Bukkalansicht", "颊面观"}},
    {"view.lingual", {"Lingual view", "Lingualansicht", "舌面观"}},
    {"turn", {"Turnable view", "Drehbare Ansicht", "可旋转视图"}},
    {"show", {"Show", "Zeigen", "显示"}},
    {"reset", {"Reset", "Zurücksetzen", "重置"}},
    {"cut_open", {"Cut open", "Aufschneiden", "剖切"}},
    {"no_script",
     {"Allow scripts in the browser to turn the result here.",
      "Sind Skripte im Browser erlaubt, lässt sich das Ergebnis hier drehen.", "启用脚本后可在此旋转查看结果。"}},
    {"viewer_alt",
     {"The result. The arrow keys turn it.", "Das Ergebnis. Die Pfeiltasten drehen es.", "可用方向键旋转的结果模型。"}},
    {"viewer_keys",
     {"Drag it or use the arrow keys to turn it; wheel or + and − to zoom; Home to reset the view.",
      "Ziehen oder Pfeiltasten drehen das Ergebnis, Rad oder + und − zoomen, Pos 1 setzt die Ansicht zurück.",
      "拖动或方向键旋转，滚轮或 + − 缩放，Home 键还原。"}},
    {"sections", {"Sections", "Schnitte", "剖面"}},
    {"sections_note",
     {"Through the place with the largest difference from the ideal.",
      "Durch die Stelle mit der größten Abweichung vom Ideal.", "通过偏离理想形态最大处的剖面。"}},
    {"section_alt",
     {"Section: the surface before, the ideal and the result.",
      "Schnitt: die Oberfläche vorher, das Ideal und das Ergebnis.", "剖面：操作前表面、理想形态与结果。"}},
    {"comparison", {"Comparison", "Vergleich", "比较"}},
    {"this_session", {"This session", "Diese Sitzung", "本次"}},
    {"last_session", {"Previous session", "Vorige Sitzung", "上一次"}},
    {"best_session", {"Best so far", "Bisher beste", "历史最佳"}},
    {"expert", {"Expert", "Fachperson", "专家"}},
    {"earlier_count",
     {"Earlier sessions of this scene: {}", "Frühere Sitzungen dieser Szene: {}", "本场景此前训练次数：{}"}},
    {"not_there", {"not reached", "nicht erreicht", "未达到"}},
    {"volumes", {"Tissue removed", "Abgetragenes Gewebe", "去除的组织"}},
    {"volumes_caption",
     {"Volumes in mm³. The ideal is the tissue that should remain.",
      "Volumen in mm³. Das Ideal ist das Gewebe, das übrig bleiben soll.",
      "体积单位为 mm³。“理想”指任务要求保留的体积。"}},
    {"encloses_nothing",
     {"The scanned surface is open: it encloses no volume, so no volume is given before and after. The removed volume "
      "lies between the surface before and after, and is known.",
      "Die gescannte Oberfläche ist offen: Sie schließt kein Volumen ein, also ist vorher und nachher keines "
      "angegeben. "
      "Das abgetragene Volumen liegt zwischen der Oberfläche vorher und nachher und ist bekannt.",
      "扫描表面是开放的，不围成体积，因此不给出操作前后的体积。去除量位于操作前后的表面之间，是已知的。"}},
    {"tissue", {"Tissue", "Gewebe", "组织"}},
    {"before", {"Before", "Vorher", "操作前"}},
    {"removed", {"Removed", "Abgetragen", "去除"}},
    {"after", {"After", "Nachher", "操作后"}},
    {"ideal", {"Ideal", "Ideal", "理想"}},
    {"share_removed", {"Share removed", "Anteil abgetragen", "去除比例"}},
    {"removed_hardness", {"Hardness of the removed tissue", "Härte des abgetragenen Gewebes", "去除组织的硬度"}},
    {"residual_caries", {"Residual caries", "Restkaries", "残余龋坏"}},
    {"course", {"Over time", "Zeitlicher Verlauf", "时间过程"}},
    {"force", {"Force on the hand", "Kraft auf die Hand", "手部受力"}},
    {"speed", {"Speed of the hand", "Geschwindigkeit der Hand", "手部速度"}},
    {"speed_note",
     {"Each value is the mean over 1/50 s, including motion in the air.",
      "Mittel über je 1/50 s, auch bei Bewegung in der Luft.", "按每 1/50 秒计算，包括空中移动。"}},
    {"spindle", {"Speed of the drill", "Drehzahl des Bohrers", "钻头转速"}},
    {"depth", {"Depth", "Eindringtiefe", "压入深度"}},
    {"depth_note",
     {"how far the hand holds the tool inside the surface that is drawn",
      "wie weit die Hand das Werkzeug unter die gezeichnete Oberfläche hält", "手持工具位置低于显示表面的距离"}},
    {"removed_course", {"Volume removed", "Abgetragenes Volumen", "累计去除体积"}},
    {"touched", {"Tissue touched", "Berührtes Gewebe", "接触的组织"}},
    {"time_axis", {"time in s", "Zeit in s", "时间（s）"}},
    {"plot_alt",
     {"{} over time: mean {} {}, maximum {} {}.", "{} im Zeitverlauf: Mittel {} {}, Maximum {} {}.",
      "{}随时间变化：平均 {} {}，最大 {} {}。"}},
    {"as_table", {"The same as a table", "Dasselbe als Tabelle", "以表格显示"}},
    {"from_to", {"Time (s)", "Zeit (s)", "时间（s）"}},
    {"mean", {"mean", "Mittel", "平均"}},
    {"greatest", {"maximum", "Maximum", "最大"}},
    {"faults", {"Faults", "Störungen", "故障"}},
    {"no_faults", {"No faults.", "Keine Störungen.", "无故障。"}},
    {"fault", {"Fault", "Störung", "故障"}},
    {"ticks", {"Ticks", "Takte", "周期数"}},
    {"first_at", {"First at (s)", "Zuerst bei (s)", "首次出现（s）"}},
    {"fault.bad_input", {"Hand pose unusable: no force", "Handlage unbrauchbar: keine Kraft", "手部位姿无效：力为零"}},
    {"fault.stale_patch",
     {"Update of the tissue over 20 ms late: the force uses the last known tissue",
      "Gewebe über 20 ms zu spät aktualisiert: die Kraft entspricht dem zuletzt bekannten Gewebe",
      "组织更新滞后超过 20 ms：力按最后已知的组织计算"}},
    {"fault.patch_edge",
     {"Tool left its patch of tissue: the last contact continues as a plane, nothing is cut",
      "Werkzeug verließ den Gewebeausschnitt: der letzte Kontakt wirkt als Ebene weiter, nichts wird abgetragen",
      "器械离开组织局部区域：最后的接触以平面形式保持，不切削"}},
    {"fault.force_limit",
     {"Force reduced to the device's limit", "Kraft auf die Grenze des Geräts begrenzt", "力被限制在设备上限"}},
    {"fault.deep_penetration",
     {"Tool found inside tissue: moved out slowly", "Werkzeug im Gewebe vorgefunden: langsam herausgeführt",
      "器械位于组织内部：缓慢引出"}},
    {"fault.device_lost",
     {"Device stopped answering: no force", "Gerät antwortet nicht: keine Kraft", "设备无响应：力为零"}},
    {"fault.slew_limit",
     {"Force rose faster than the device allows", "Kraft stieg schneller, als das Gerät erlaubt",
      "力上升速度超过设备允许值"}},
    {"fault.let_go",
     {"The servo was late; the motors were switched to zero force",
      "Die Regelung kam zu spät; die Motoren wurden kraftlos geschaltet", "伺服延迟，电机已断力"}},
    {"fault.no_room",
     {"No room for more filling near the instrument: none is added",
      "Kein Platz für mehr Füllung am Instrument: nicht eingebracht", "器械附近已无充填空间：未充入"}},
    {"fault.held",
     {"Stopped by the emergency key: no drill, no force", "Durch die Nottaste angehalten: kein Bohrer, keine Kraft",
      "已按急停键：钻头停转、力为零"}},
    {"fault.wedged",
     {"Tool is stuck and does not follow the hand: move it out along the path it went in",
      "Werkzeug steckt fest und folgt der Hand nicht: auf dem Weg herausnehmen, auf dem es hineinkam",
      "器械卡住，未跟随手：请沿进入的路径退出"}},
    {"fault.overrun", {"Tick took longer than its period", "Takt dauerte länger als seine Periode", "周期超时"}},
    {"timing", {"Servo timing", "Servo-Zeitverhalten", "伺服时序"}},
    {"timing_caption",
     {"CPU time of a tick. A tick at this rate has {} µs.", "CPU-Zeit eines Takts. Bei dieser Rate hat ein Takt {} µs.",
      "每个周期的 CPU 时间。此频率下一个周期为 {} µs。"}},
    {"median", {"Median", "Median", "中位数"}},
    {"worst", {"Worst", "Schlechtester", "最差"}},
    {"histogram_alt",
     {"Histogram of the CPU time of {} ticks: median {} µs, 99 % below {} µs, worst {} µs.",
      "Histogramm der CPU-Zeit von {} Takten: Median {} µs, 99 % unter {} µs, schlechtester {} µs.",
      "{} 个周期的 CPU 时间直方图：中位数 {} µs，99 % 低于 {} µs，最差 {} µs。"}},
    {"headset", {"Frames in the headset", "Bilder im Headset", "头显帧时序"}},
    {"headset_frames",
     {"{} frames, {} of them with a picture; {} pictures of the display were missed.",
      "{} Bilder, {} davon gezeichnet; {} Bilder der Anzeige wurden verpasst.",
      "共 {} 帧，其中 {} 帧有画面；错过 {} 次显示刷新。"}},
    {"headset_caption",
     {"Prediction error: the head's pose predicted for the time of display, compared with the pose measured "
      "afterwards.",
      "Vorhersagefehler: die für die Anzeige vorhergesagte Lage des Kopfs, verglichen mit der danach gemessenen Lage.",
      "预测误差：预测显示时刻的头部位姿与事后查询的实际位姿之差。"}},
    {"picture", {"Frames of the picture", "Bilder auf dem Schirm", "画面帧时序"}},
    {"picture_frames",
     {"{} frames were drawn because something had moved; on average {} % of a frame was redrawn; quality between "
      "steps {} and {} "
      "(1: best).",
      "{} Bilder wurden gezeichnet, weil sich etwas bewegt hatte, im Mittel {} % davon neu; Qualität zwischen Stufe {} "
      "und {} "
      "(1: beste).",
      "因画面变化共绘制 {} 帧，平均每帧重绘 {} %；画质级别介于 {} 与 {} 之间（1 为最佳）。"}},
    {"picture_caption",
     {"The delay from hand to screen is estimated: age of the hand's sample, preparing, drawing, half a "
      "refresh period of the screen.",
      "Von der Hand zum Schirm ist geschätzt: Alter der Abtastung, Vorbereiten, Zeichnen, halbe Bildperiode des "
      "Schirms.",
      "手到屏幕的延迟为估计值：采样时延、准备、绘制以及半个刷新周期之和。"}},
    {"frame_period", {"From frame to frame", "Von Bild zu Bild", "帧间隔"}},
    {"frame_record", {"Preparing and handing over", "Vorbereiten und Übergeben", "准备与提交"}},
    {"frame_gpu", {"Drawing, by the GPU's clock", "Zeichnen, nach der Uhr der GPU", "绘制（GPU 时钟）"}},
    {"motion_to_photon", {"From hand to screen", "Von der Hand zum Schirm", "从手部运动到屏幕显示"}},
    {"sound_caption",
     {"Delay of the sound: measured from the arrival of the ticks, plus the delay that the sound device states.",
      "Verzögerung des Klangs: gemessen an der Ankunft der Takte, zuzüglich der vom Tongerät angegebenen Verzögerung.",
      "声音延迟：由周期到达时间测得，并含声卡自报的延迟。"}},
    {"hand_to_sound", {"From hand to sound", "Von der Hand zum Klang", "从手部运动到声音"}},
    {"pose_to_submit",
     {"From pose to submitted picture", "Von der Pose bis zur Übergabe des Bilds", "从取位姿到提交画面"}},
    {"frame_margin", {"Time left until display", "Verbleibende Zeit bis zur Anzeige", "距显示的剩余时间"}},
    {"head_error", {"Prediction error, position", "Vorhersagefehler, Position", "预测误差（位置）"}},
    {"head_angle_error", {"Prediction error, direction", "Vorhersagefehler, Richtung", "预测误差（方向）"}},
    {"loop_caption",
     {"The live force loop: {} ticks; {} of them ended after the next sample was due ({} %). Longest tick at {} s.",
      "Die Kraftregelung im Betrieb: {} Takte, davon {} erst nach der nächsten Abtastung fertig ({} %). Längster Takt "
      "bei {} s.",
      "实时力觉循环：共 {} 个周期，其中 {} 个在下一次采样时尚未完成（{} %）。最长周期出现在 {} s。"}},
    {"loop_work", {"From sample to force", "Von der Abtastung zur Kraft", "从采样到输出力"}},
    {"loop_jitter", {"Jitter of the wake-ups", "Abweichung vom Takt", "唤醒抖动"}},
    {"loop_jitter_alt",
     {"Histogram of the jitter of {} wake-ups: median {} µs, 99 % below {} µs, worst {} µs.",
      "Histogramm der Abweichung von {} Weckzeiten vom Takt: Median {} µs, 99 % unter {} µs, schlechteste {} µs.",
      "{} 次唤醒时间偏差直方图：中位数 {} µs，99 % 低于 {} µs，最差 {} µs。"}},
    {"realtime", {"Real time", "Echtzeit", "实时条件"}},
    {"realtime.fifo", {"Real-time priority", "Echtzeitpriorität", "实时优先级"}},
    {"realtime.pinned", {"Reserved processor core", "Eigener Prozessorkern", "独占处理器核心"}},
    {"realtime.locked", {"Locked memory", "Gesperrter Speicher", "内存锁定"}},
    {"realtime.yes", {"granted", "gewährt", "已获准"}},
    {"realtime.no",
     {"not granted: the loop may sometimes be late; typodont doctor names the remedy",
      "nicht gewährt: die Schleife kommt manchmal zu spät; typodont doctor nennt die Abhilfe",
      "未获准：循环可能偶尔被延迟；typodont doctor 会说明解决办法"}},
    {"motor_heat", {"Motors, warmest", "Motoren, am wärmsten", "电机最高热负荷"}},
    {"motor_heat_value", {"{} % of their limit", "{} % ihrer Grenze", "达承受上限的 {} %"}},
    {"safety", {"Interventions of the safety layer", "Eingriffe der Sicherheitsschicht", "安全保护动作"}},
    {"safety.none", {"none", "keine", "无"}},
    {"safety.not_finite",
     {"a force or pose that was not a number", "eine Kraft oder Lage, die keine Zahl war", "力或位姿不是有效数值"}},
    {"safety.force_limit", {"force limited to the peak force", "Kraft auf die Spitzenkraft begrenzt", "力限制在峰值"}},
    {"safety.slew_limit", {"rise of the force limited", "Kraftanstieg gebremst", "力上升被减缓"}},
    {"safety.thermal",
     {"force limited because of warm motors", "Kraft wegen warmer Motoren begrenzt", "因电机发热而限力"}},
    {"safety.watchdog",
     {"the servo stopped writing: no force", "Servo schrieb nichts mehr: keine Kraft", "伺服无响应：力为零"}},
    {"safety.device_fault",
     {"the device reported a fault: no force", "Gerät meldete Störung: keine Kraft", "设备报告故障：力为零"}},
    {"safety.device_lost", {"the device was unplugged: no force", "Gerät abgezogen: keine Kraft", "设备断开：力为零"}},
    {"safety.jump", {"the hand's position jumped: no force", "Sprung der Hand: keine Kraft", "手部位置跳变：力为零"}},
    {"safety.clock", {"the clock jumped: no force", "Zeitsprung: keine Kraft", "时间跳变：力为零"}},
    {"safety.emergency", {"emergency stop", "Not-Halt", "紧急停止"}},
    {"safety.pedal_stuck",
     {"the pedal was pressed too long: drill off", "Pedal zu lange gehalten: Bohrer aus", "踏板按住过久：钻停止"}},
    {"events", {"Events", "Ereignisse", "事件"}},
    {"more_events", {"{} more in the session file", "{} weitere in der Sitzungsdatei", "训练文件中还有 {} 条"}},
    {"when", {"Time (s)", "Zeit (s)", "时间（s）"}},
    {"what", {"What", "Was", "内容"}},
    {"event.note", {"Note", "Notiz", "备注"}},
    {"event.tool", {"Tool", "Werkzeug", "器械"}},
    {"event.view", {"View", "Ansicht", "视图"}},
    {"event.fault", {"Fault", "Störung", "故障"}},
    {"event.task", {"Task", "Aufgabe", "任务"}},
    {"event.undo", {"Undo", "Rückgängig", "撤销"}},
    {"event.redo", {"Redo", "Wiederholen", "重做"}},
    {"event.piece", {"Loose piece taken out", "Loses Stück entfernt", "移除游离碎块"}},
    {"event.score", {"Score", "Bewertung", "评分"}},
    {"details", {"Session data", "Angaben zur Sitzung", "训练信息"}},
    {"scene", {"Scene", "Szene", "场景"}},
    {"trainee", {"Trainee", "Übende Person", "学员"}},
    {"date", {"Date", "Datum", "日期"}},
    {"duration", {"Duration", "Dauer", "时长"}},
    {"hand", {"Hand", "Hand", "手部设备"}},
    {"tools", {"Tools", "Werkzeuge", "器械列表"}},
    {"servo_rate", {"Servo rate", "Servorate", "伺服频率"}},
    {"voxel", {"Voxel", "Voxel", "体素"}},
    {"program", {"Program", "Programm", "程序版本"}},
    {"compiler", {"Compiler", "Übersetzer", "编译器"}},
    {"seeds", {"Seeds", "Startwerte", "随机种子"}},
    {"files", {"Files", "Dateien", "文件"}},
    {"verification", {"Checked by a replay", "Durch Wiederholung geprüft", "经重放核对"}},
    {"verification.none",
     {"no: the score trusts this file (report --verify, or replay --check)",
      "nein: die Wertung vertraut dieser Datei (report --verify oder replay --check)",
      "否：评分以此文件为准（可用 report --verify 或 replay --check 核对）"}},
    {"verification.identical",
     {"yes, identical in every column from which the score is computed",
      "ja, gleich in jeder Spalte, aus der die Wertung berechnet wird", "是，评分所用各列均一致"}},
    {"warn.differs",
     {"A replay of the recorded motion of the hand differs from this recording: {}. So the score in this "
      "recording is not the score of that motion.",
      "Die Wiederholung der aufgezeichneten Hand weicht von dieser Aufnahme ab: {}. Ihre Wertung ist nicht die der "
      "Hand.",
      "按所记录的手部动作重放，结果与本记录不一致：{}。其评分不代表该操作。"}},
    {"warn.other_law",
     {"This recording was made with another force law (by Typodont {}). With today's law, the force on the same hand "
      "differs by {} N rms and {} N at most, and the hand removes {} mm³ instead of {} mm³.",
      "Diese Aufnahme entstand mit einem anderen Kraftgesetz (Typodont {}). Mit dem heutigen Gesetz weicht die Kraft "
      "auf "
      "dieselbe Hand um {} N (Effektivwert), höchstens um {} N ab, und die Hand trägt {} mm³ statt {} mm³ ab.",
      "本记录使用其他力学规则（Typodont {}）。按现行规则，同一手部动作所受的力相差 {} N（均方根），最大 {} "
      "N；去除体积为 "
      "{} mm³，原为 {} mm³。"}},
    {"session_file", {"Session file", "Sitzungsdatei", "训练文件"}},
    {"warn.truncated",
     {"This recording was cut off before its end; the report covers what was saved.",
      "Diese Aufnahme brach vor ihrem Ende ab; der Bericht umfasst, was gesichert wurde.",
      "本次记录在结束前中断；报告仅包含已保存的部分。"}},
    {"warn.lost",
     {"{} ticks, {} cuts, {} pictures and {} other entries did not reach the file.",
      "{} Takte, {} Schnitte, {} Bilder und {} andere Einträge gelangten nicht in die Datei.",
      "有 {} 个周期、{} 次切削、{} 张图片和 {} 条其他记录未写入文件。"}},
    {"warn.gaps",
     {"The recording has gaps: {}. What was cut in them is missing from the tissue shown here and from its score.",
      "Die Aufnahme hat Lücken: {}. Was darin geschnitten wurde, fehlt im gezeigten Gewebe und in seiner Wertung.",
      "记录存在缺口：{}。其间的切削未包含在此处显示的组织及其评分中。"}},
    {"warn.no_ticks", {"Nothing was recorded.", "Es wurde nichts aufgezeichnet.", "没有任何记录。"}},
    {"attention", {"Attention", "Achtung", "注意"}},
    {"made_by", {"Made by Typodont {}", "Erstellt mit Typodont {}", "由 Typodont {} 生成"}},
    {"free", {"free", "frei", "未接触"}},
    {"other", {"other", "andere", "其他"}},

    {kDefaultPassSource,
     {kDefaultPassSource,
      "75 von 100, wie in der zahnärztlichen Zulassungsprüfung ADEX; Vorgabe von Typodont, in der Szene einstellbar",
      "75 分（满分 100），同 ADEX 牙医执业资格考试；Typodont 默认值，可在场景中设定"}},
    {"Typodont's default; set it in the scene",
     {"Typodont's default; set it in the scene", "Vorgabe von Typodont; in der Szene einstellbar",
      "Typodont 默认值；可在场景中设定"}},
    {"Half a millimetre of dentin left over the pulp; Typodont's default",
     {"Half a millimetre of dentin left over the pulp; Typodont's default",
      "Ein halber Millimeter Dentin bleibt über der Pulpa; Vorgabe von Typodont",
      "牙髓上方保留 0.5 mm 牙本质；Typodont 默认值"}},
    {"Hand forces of 0.34 to 1.03 N measured on teeth",
     {"Hand forces of 0.34 to 1.03 N measured on teeth", "An Zähnen gemessene Handkräfte von 0,34 bis 1,03 N",
      "在牙齿上实测的手部力为 0.34 至 1.03 N"}},
    {"Lateral loads of up to 3 N measured on teeth",
     {"Lateral loads of up to 3 N measured on teeth", "An Zähnen gemessene Seitenlasten bis 3 N",
      "在牙齿上实测的侧向力可达 3 N"}},
    {"As much as the caries, for the access; Typodont's default",
     {"As much as the caries, for the access; Typodont's default",
      "So viel wie die Karies, für den Zugang; Vorgabe von Typodont", "为建立入路，允许与龋坏等量；Typodont 默认值"}},

    {"Pulpal depth 1.5 mm at the fissure, about 2 mm on the outer walls, 0.1 to 0.2 mm into dentin",
     {"Pulpal depth 1.5 mm at the fissure, about 2 mm on the outer walls, 0.1 to 0.2 mm into dentin",
      "Tiefe 1,5 mm an der Fissur, etwa 2 mm an den Außenwänden, 0,1 bis 0,2 mm im Dentin",
      "窝沟处洞深 1.5 mm，外侧壁约 2 mm，进入牙本质 0.1 至 0.2 mm"}},
    {"Isthmus of 1.2 to 1.7 mm", {"Isthmus of 1.2 to 1.7 mm", "Isthmus von 1,2 bis 1,7 mm", "峡部宽 1.2 至 1.7 mm"}},
    {"Walls parallel or converging towards the opening",
     {"Walls parallel or converging towards the opening", "Wände parallel oder zur Öffnung hin konvergierend",
      "洞壁平行或向开口处内聚"}},
    {"Convergence of 10 to 20°", {"Convergence of 10 to 20°", "Konvergenzwinkel von 10 bis 20°", "聚合度 10 至 20°"}},
    {"Occlusal reduction of 1.5 to 2 mm, axial of 1 mm",
     {"Occlusal reduction of 1.5 to 2 mm, axial of 1 mm", "Okklusaler Abtrag 1,5 bis 2 mm, axialer 1 mm",
      "咬合面磨除 1.5 至 2 mm，轴面磨除 1 mm"}},

    {"tissue.air", {"Air", "Luft", "空气"}},
    {"tissue.enamel", {"Enamel", "Schmelz", "牙釉质"}},
    {"tissue.dentin", {"Dentin", "Dentin", "牙本质"}},
    {"tissue.caries", {"Caries", "Karies", "龋坏"}},
    {"tissue.pulp", {"Pulp", "Pulpa", "牙髓"}},
    {"tissue.cortical_bone", {"Cortical bone", "Kortikaler Knochen", "皮质骨"}},
    {"tissue.cancellous_bone", {"Cancellous bone", "Spongiosa", "松质骨"}},
    {"tissue.gingiva", {"Gingiva", "Gingiva", "牙龈"}},
    {"tissue.amalgam", {"Amalgam", "Amalgam", "银汞合金"}},
    {"tissue.composite", {"Composite", "Komposit", "复合树脂"}},

    {"tool.carrier_amalgam", {"Amalgam carrier", "Amalgampistole", "银汞合金输送器"}},
    {"tool.carver_cleoid", {"Cleoid carver", "Cleoid-Schnitzer", "爪形雕刻器"}},
    {"tool.carver_discoid", {"Discoid carver", "Discoid-Schnitzer", "盘形雕刻器"}},
    {"tool.condenser_amalgam", {"Amalgam condenser", "Amalgamstopfer", "银汞合金充填器"}},
    {"tool.condenser_composite", {"Composite condenser", "Kompositstopfer", "树脂充填器"}},
    {"tool.cone", {"Cone bur", "Kegelbohrer", "锥形钻"}},
    {"tool.cylinder", {"Cylinder bur", "Zylinderbohrer", "柱形钻"}},
    {"tool.end_guarded_cylinder", {"Cylinder bur with safe end", "Zylinderbohrer mit Schutzspitze", "端部防护柱形钻"}},
    {"tool.excavator_spoon", {"Spoon excavator", "Löffelexkavator", "挖匙"}},
    {"tool.explorer", {"Explorer", "Sonde", "探针"}},
    {"tool.flame", {"Flame bur", "Flammenbohrer", "火焰形钻"}},
    {"tool.gauge", {"Gauge", "Messlehre", "量规"}},
    {"tool.implant_drill", {"Implant drill", "Implantatbohrer", "种植钻"}},
    {"tool.implant_round", {"Implant round bur", "Implantat-Rundbohrer", "种植球钻"}},
    {"tool.inverted_cone", {"Inverted cone bur", "Umgekehrter Kegelbohrer", "倒锥钻"}},
    {"tool.pear", {"Pear bur", "Birnenbohrer", "梨形钻"}},
    {"tool.probe_ball", {"Ball probe", "Kugelsonde", "球形探针"}},
    {"tool.probe_who", {"WHO probe", "WHO-Sonde", "WHO 探针"}},
    {"tool.round", {"Round bur", "Rundbohrer", "球钻"}},
    {"tool.round_end_cylinder", {"Round-end cylinder bur", "Zylinderbohrer mit runder Stirn", "圆头柱形钻"}},
    {"tool.round_end_cylinder_coarse",
     {"Coarse round-end cylinder diamond", "Grober Diamant-Zylinder mit runder Stirn", "粗粒圆头柱形金刚砂钻"}},

    {"score.residual_caries_mm3", {"Residual caries, volume", "Restkaries, Volumen", "残余龋坏体积"}},
    {"score.residual_caries_percent", {"Residual caries, share", "Restkaries, Anteil", "残余龋坏比例"}},
    {"score.over_cut_mm3", {"Cut too deep, volume", "Zu tief abgetragen, Volumen", "过度切削体积"}},
    {"score.under_cut_mm3", {"Too much left, volume", "Zu viel übrig, Volumen", "残留过多体积"}},
    {"score.over_cut_depth_mm", {"Cut too deep, depth", "Zu tief abgetragen, Tiefe", "最大过切深度"}},
    {"score.under_cut_depth_mm", {"Too much left, thickness", "Zu viel übrig, Dicke", "最大残留厚度"}},
    {"score.contour_rms_um",
     {"Distance of the surface from the ideal (rms)", "Abstand der Fläche vom Ideal (Effektivwert)",
      "表面偏离理想形态（均方根）"}},
    {"score.floor_depth_mm", {"Depth of the floor", "Tiefe des Bodens", "洞底深度"}},
    {"score.floor_flatness_um",
     {"Unevenness of the floor (rms)", "Unebenheit des Bodens (Effektivwert)", "洞底不平整度（均方根）"}},
    {"score.floor_tilt_deg", {"Tilt of the floor", "Neigung des Bodens", "洞底倾斜角"}},
    {"score.taper_deg",
     {"Taper, both walls together", "Konvergenzwinkel, beide Wände zusammen", "聚合度（两侧壁合计）"}},
    {"score.axial_depth_mm", {"Axial reduction", "Axialer Abtrag", "轴面磨除量"}},
    {"score.isthmus_mm", {"Width of the isthmus", "Breite des Isthmus", "峡部宽度"}},
    {"score.wall_thickness_mm", {"Thinnest wall", "Dünnste Wand", "最薄壁厚"}},
    {"score.cup_center_mm",
     {"Distance of the cup's centre from the ideal", "Abstand der Pfannenmitte vom Ideal", "髋臼杯中心偏离理想位置"}},
    {"score.cup_radius_mm", {"Radius of the cup", "Radius der Pfanne", "髋臼杯半径"}},
    {"score.cup_angle_deg",
     {"Angle of the cup's opening from the ideal", "Winkel der Pfannenöffnung zum Ideal", "髋臼杯开口角度偏差"}},
    {"score.margin_roughness_um",
     {"Roughness of the margin (rms)", "Rauheit des Randes (Effektivwert)", "边缘粗糙度（均方根）"}},
    {"score.gingiva_removed_mm3", {"Gingiva cut away", "Gingiva abgetragen", "切除的牙龈"}},
    {"score.neighbour_removed_mm3", {"Neighbouring tooth cut", "Nachbarzahn verletzt", "邻牙损伤"}},
    {"score.protected_removed_mm3", {"Protected part cut", "Geschützter Teil verletzt", "保护区域损伤"}},
    {"score.pulp_exposed_mm2", {"Exposed pulp", "Eröffnete Pulpa", "牙髓暴露面积"}},
    {"score.lesions_found_percent", {"Lesions found", "Läsionen gefunden", "发现的龋损"}},
    {"score.false_finds", {"Sound tissue marked as caries", "Gesundes als Karies markiert", "误判为龋坏的次数"}},
    {"score.explored_percent", {"Surface explored", "Fläche abgetastet", "已探查表面"}},
    {"score.healthy_removed_mm3", {"Healthy tissue removed", "Gesundes Gewebe abgetragen", "去除的健康组织"}},
    {"score.pulp_removed_mm3", {"Pulp cut away", "Pulpa abgetragen", "切除的牙髓"}},
    {"score.pulp_distance_mm", {"Nearest distance to the pulp", "Kleinster Abstand zur Pulpa", "距牙髓最近距离"}},
    {"implant.title", {"Implant procedure, phase by phase", "Implantation, Phase für Phase", "种植步骤"}},
    {"implant.models",
     {"The line is the force along the planned axis, the band reaches to the force across it. Bone temperature and "
      "insertion torque are estimates of stated models. No program can check how realistic this feels.",
      "Die Linie ist die Kraft in der geplanten Achse, das Band reicht bis zur Kraft quer dazu. Knochentemperatur und "
      "Eindrehmoment sind Schätzungen nach genannten Modellen. Wie echt es sich anfühlt, kann kein Programm prüfen.",
      "曲线为沿计划轴向的力，色带延伸至横向力。骨温度和植入扭矩为模型估计值；真实感无法由程序检验。"}},
    {"implant.phase", {"Phase", "Phase", "步骤"}},
    {"implant.state", {"State", "Stand", "状态"}},
    {"implant.depth", {"Depth", "Tiefe", "深度"}},
    {"implant.temperature", {"Bone temperature", "Knochentemperatur", "骨温度"}},
    {"implant.notes", {"Hints", "Hinweise", "提示"}},
    {"implant.done", {"done", "erledigt", "完成"}},
    {"implant.skipped", {"skipped", "übersprungen", "跳过"}},
    {"implant.open", {"not done", "nicht erledigt", "未完成"}},
    {"implant.note.wrong_tool", {"Wrong instrument", "Falsches Instrument", "器械错误"}},
    {"implant.note.over_speed", {"Too fast: lower the speed", "Zu schnell: Drehzahl senken", "转速过高"}},
    {"implant.note.too_deep", {"Too deep", "Zu tief", "过深"}},
    {"implant.note.off_axis", {"Off the planned axis", "Neben der geplanten Achse", "偏离计划轴向"}},
    {"implant.note.near_canal", {"Too close to the nerve canal", "Zu nah am Nervkanal", "距神经管过近"}},
    {"implant.note.heat", {"Bone too hot: lift the drill", "Knochen zu heiß: Bohrer abheben", "骨温过高：抬起钻头"}},
    {"implant.note.over_force", {"Too much force", "Zu viel Kraft", "用力过大"}},
    {"score.implant_phases_percent", {"Phases done", "Phasen erledigt", "完成的步骤"}},
    {"score.implant_entry_mm", {"Distance of the entry from the plan", "Abstand des Eintritts vom Plan", "入口偏差"}},
    {"score.implant_apex_mm", {"Distance of the apex from the plan", "Abstand der Spitze vom Plan", "根尖偏差"}},
    {"score.implant_angle_deg", {"Angle of the axis to the plan", "Winkel der Achse zum Plan", "轴向偏差"}},
    {"score.bed_depth_mm", {"Depth of the bed", "Tiefe des Implantatbetts", "种植窝深度"}},
    {"score.bed_diameter_mm", {"Diameter of the bed", "Durchmesser des Implantatbetts", "种植窝直径"}},
    {"score.bed_ovality_mm", {"Ovality of the bed", "Unrundheit des Implantatbetts", "种植窝椭圆度"}},
    {"score.cortical_perforation_percent",
     {"Wall of the bed without bone behind it", "Bettwand ohne Knochen dahinter", "窝壁穿通比例"}},
    {"score.canal_distance_mm", {"Distance to the nerve canal", "Abstand zum Nervkanal", "距神经管距离"}},
    {"score.neighbour_distance_mm", {"Distance to the nearest root", "Abstand zur nächsten Wurzel", "距邻牙根距离"}},
    {"score.insertion_torque_Ncm", {"Insertion torque", "Eindrehmoment", "植入扭矩"}},
    {"score.bone_contact_percent",
     {"Implant surface in bone (primary stability)", "Implantatfläche im Knochen (Primärstabilität)",
      "骨接触面积（初期稳定性）"}},
    {"score.over_force_s", {"Time above the force limit", "Zeit über der Kraftgrenze", "超力时间"}},
    {"score.bone_temperature_C", {"Bone temperature (estimate)", "Knochentemperatur (Schätzung)", "骨温度（估计）"}},
    {"score.force_mean_N", {"Force, mean in contact", "Kraft, Mittel bei Kontakt", "接触时平均力"}},
    {"score.force_max_N", {"Force, maximum", "Kraft, Maximum", "最大力"}},
    {"score.path_length_mm", {"Path of the hand", "Weg der Hand", "手部路径长度"}},
    {"score.time_s", {"Time", "Zeit", "用时"}},
    {"score.contact_time_s", {"Time in contact", "Zeit mit Kontakt", "接触时间"}},
    {"score.strokes", {"Strokes", "Züge", "操作次数"}},
    {"score.tremor_rms_um",
     {"Tremor (above 5 Hz, rms)", "Tremor (über 5 Hz, Effektivwert)", "震颤（5 Hz 以上，均方根）"}},
};

const Entry* find(std::string_view key) noexcept {
  for (const std::span<const Entry> part :
       {std::span<const Entry>(kCatalogue), operator_catalogue(), hud_catalogue()}) {
    const auto it = std::find_if(part.begin(), part.end(), [&](const Entry& e) { return e.key == key; });
    if (it != part.end()) return &*it;
  }
  return nullptr;
}

}  // namespace

std::optional<Language> language_named(std::string_view tag) noexcept {
  const std::string_view code = tag.substr(0, tag.find_first_of("_-."));
  if (code == "en" || code == "C" || code == "POSIX") return Language::kEnglish;
  if (code == "de") return Language::kGerman;
  if (code == "zh") return Language::kChinese;
  return std::nullopt;
}

Language system_language() noexcept {
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    const char* value = std::getenv(name);
    if (value && *value) return language_named(value).value_or(Language::kEnglish);
  }
  return Language::kEnglish;
}

std::string_view tag_of(Language language) noexcept {
  switch (language) {
    case Language::kGerman:
      return "de";
    case Language::kChinese:
      return "zh-Hans";
    default:
      return "en";
  }
}

std::string_view text(std::string_view key, Language language) noexcept {
  const Entry* entry = find(key);
  return entry ? entry->text[static_cast<std::size_t>(language)] : key;
}

bool has_text(std::string_view key) noexcept {
  return find(key) != nullptr;
}

std::string tool_text(std::string_view name, Language language) {
  const std::string_view kind = name.substr(0, name.find_last_not_of("_0123456789") + 1);
  const std::string key = fmt::format("tool.{}", kind);
  if (has_text(key)) return std::string(text(key, language));
  std::string plain(kind.empty() ? name : kind);
  std::replace(plain.begin(), plain.end(), '_', ' ');
  std::replace(plain.begin(), plain.end(), '-', ' ');
  if (!plain.empty()) plain[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(plain[0])));
  return plain;
}

std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked) {
  return {{{"realtime.fifo", fifo}, {"realtime.pinned", pinned}, {"realtime.locked", memory_locked}}};
}

std::vector<std::string_view> catalogue_keys() {
  std::vector<std::string_view> keys;
  for (const Entry& entry : kCatalogue) keys.push_back(entry.key);
  for (const std::span<const Entry> part : {operator_catalogue(), hud_catalogue()})
    for (const Entry& entry : part) keys.push_back(entry.key);
  return keys;
}

std::string number_text(double v, int decimals, Language language) {
  std::string s = fmt::format("{:.{}f}", v, decimals);
  if (s.starts_with("-") && s.find_first_not_of("-0.") == std::string::npos) s.erase(0, 1);
  if (language == Language::kGerman) std::replace(s.begin(), s.end(), '.', ',');
  return s;
}

std::string number_text(double v, Language language) {
  const double a = std::abs(v);
  return number_text(v, a < 5e-4 || a >= 100 ? 0 : a >= 10 ? 1 : a >= 1 ? 2 : 3, language);
}

std::string quantity_text(double v, std::string_view unit, Language language) {
  if (std::isnan(v)) return "–";
  return unit.empty() ? number_text(v, 0, language) : fmt::format("{}\u00a0{}", number_text(v, language), unit);
}

}  // namespace typodont::session
