"""Texts in three languages."""
import json
from . import settings

LANGUAGES = {"en": "English", "de": "Deutsch", "zh": "中文"}
TEXTS = {
    "school": ("Typodont school", "Typodont-Schule", "Typodont 学校"),
    "skip": ("Skip to content", "Zum Inhalt", "跳至内容"),
    "sign_in": ("Sign in", "Anmelden", "登录"),
    "sign_out": ("Sign out", "Abmelden", "退出"),
    "name": ("User name", "Benutzername", "用户名"),
    "password": ("Password", "Passwort", "密码"),
    "old_password": ("Present password", "Bisheriges Passwort", "当前密码"),
    "new_password": ("New password (at least 10 characters)", "Neues Passwort (mindestens 10 Zeichen)", "新密码（至少 10 个字符）"),
    "change_password": ("Change password", "Passwort ändern", "修改密码"),
    "changed": ("The password was changed.", "Das Passwort wurde geändert.", "密码已修改。"),
    "wrong": ("User name or password is wrong.", "Benutzername oder Passwort ist falsch.", "用户名或密码错误。"),
    "too_many": ("Too many attempts. Try again in 15 minutes.", "Zu viele Versuche. Bitte in 15 Minuten erneut.", "尝试次数过多，请 15 分钟后再试。"),
    "language": ("Language", "Sprache", "语言"),
    "choose": ("Choose", "Wählen", "选择"),
    "classes": ("Classes", "Klassen", "班级"),
    "class": ("Class", "Klasse", "班级"),
    "students": ("Students", "Studierende", "学生"),
    "student": ("Student", "Studierende Person", "学生"),
    "my_page": ("My page", "Meine Seite", "我的页面"),
    "sessions": ("Sessions", "Sitzungen", "练习记录"),
    "session": ("Session", "Sitzung", "练习"),
    "exercise": ("Exercise", "Übung", "练习项目"),
    "exercises": ("Exercises", "Übungen", "练习项目"),
    "assignments": ("Assignments", "Aufgaben", "作业"),
    "assign": ("Assign", "Aufgeben", "布置"),
    "due": ("Due", "Fällig", "截止"),
    "attempts": ("Attempts", "Versuche", "次数"),
    "attempt": ("Attempt", "Versuch", "第几次"),
    "done_of": ("{done} of {all} done", "{done} von {all} erledigt", "已完成 {done}/{all}"),
    "sealed": ("Sealed exam", "Versiegelte Prüfung", "密封考试"),
    "open_until": ("open until", "offen bis", "开放至"),
    "last": ("Last", "Zuletzt", "最近"),
    "last_score": ("Last score", "Letzte Punktzahl", "最近得分"),
    "mean": ("Mean", "Mittel", "平均"),
    "best": ("Best", "Beste", "最佳"),
    "trend": ("Trend", "Verlauf", "趋势"),
    "score": ("Score", "Punkte", "得分"),
    "points": ("Points", "Punkte", "分数"),
    "passed": ("passed", "bestanden", "通过"),
    "failed": ("not passed", "nicht bestanden", "未通过"),
    "passed_share": ("Passed", "Bestanden", "通过率"),
    "duration": ("Duration", "Dauer", "时长"),
    "received": ("Handed in", "Abgegeben", "提交时间"),
    "state": ("State", "Stand", "状态"),
    "waiting": ("being checked", "wird geprüft", "检查中"),
    "accepted": ("checked", "geprüft", "已检查"),
    "refused": ("refused", "abgelehnt", "已拒绝"),
    "learning_curve": ("Learning curve", "Lernkurve", "学习曲线"),
    "curve_note": ("Line: mean of the class. Band: 95 % interval of the mean (four or more students).",
                   "Linie: Mittel der Klasse. Band: 95-%-Intervall des Mittels (ab vier Studierenden).",
                   "线：班级平均分。色带：平均值的 95% 区间（四人以上）。"),
    "curve_own": ("Dots: this student's attempts.", "Punkte: Versuche dieser Person.", "圆点：该学生的各次成绩。"),
    "distribution": ("Distribution of scores", "Verteilung der Punkte", "得分分布"),
    "defects": ("Defects", "Fehler", "缺陷"),
    "defect": ("Defect", "Fehler", "缺陷"),
    "lost": ("Points lost, mean", "Verlorene Punkte, Mittel", "平均失分"),
    "commonest_place": ("Commonest place", "Häufigste Stelle", "最常见位置"),
    "value": ("Value", "Wert", "数值"),
    "other_values": ("Other values", "Weitere Werte", "其他数值"),
    "target": ("Target", "Ziel", "目标"),
    "place": ("Place of the largest deviation", "Stelle der größten Abweichung", "最大偏差位置"),
    "count": ("Sessions", "Sitzungen", "次数"),
    "as_table": ("As a table", "Als Tabelle", "以表格显示"),
    "result_3d": ("Result in 3-D", "Ergebnis in 3-D", "三维结果"),
    "view_help": ("Turn with the mouse or the arrow keys; zoom with the wheel or + and −.",
                  "Drehen mit der Maus oder den Pfeiltasten; Zoom mit dem Rad oder + und −.", "用鼠标或方向键旋转；用滚轮或 + 和 − 缩放。"),
    "view_none": ("This browser shows no 3-D view.", "Dieser Browser zeigt keine 3-D-Ansicht.", "此浏览器无法显示三维视图。"),
    "full_report": ("Full report", "Ganzer Bericht", "完整报告"),
    "recording": ("Recording (.h5)", "Aufzeichnung (.h5)", "记录文件 (.h5)"),
    "check_home": ("Check this mark at home", "Diese Note zu Hause prüfen", "在家核对此成绩"),
    "check_text": ("Download the recording. This command simulates it again and compares every tick; the hash of its file is shown below.",
                   "Laden Sie die Aufzeichnung herunter. Dieser Befehl simuliert sie erneut und vergleicht jeden Takt; unten steht der Hash der Datei.",
                   "下载记录文件。以下命令会重新模拟并逐步比较；文件的哈希值如下。"),
    "checked_text": ("The server has replayed this recording bit for bit and computed the score from it.",
                     "Der Server hat diese Aufzeichnung Bit für Bit wiederholt und die Punkte daraus berechnet.",
                     "服务器已逐位重放此记录，并据此计算得分。"),
    "truncated": ("The recording was cut off.", "Die Aufzeichnung brach ab.", "记录不完整。"),
    "remarks": ("Remarks", "Bemerkungen", "评语"),
    "remark": ("Remark", "Bemerkung", "评语"),
    "write_remark": ("Write a remark", "Bemerkung schreiben", "写评语"),
    "strokes": ("Defects and their strokes", "Fehler und ihre Züge", "缺陷及其操作"),
    "play_strokes": ("Play the strokes in the report", "Züge im Bericht abspielen", "在报告中播放操作"),
    "closest": ("no stroke made it; this one came closest", "durch keinen Zug entstanden; dieser kam am nächsten", "并非由操作造成；此操作最接近该处"),
    "change_remark": ("Change", "Ändern", "修改"),
    "at_s": ("At, s (may be empty)", "Bei, s (kann leer sein)", "时刻（秒，可空）"),
    "remarks_file": ("Remarks (.json)", "Bemerkungen (.json)", "评语 (.json)"),
    "save": ("Save", "Speichern", "保存"),
    "none": ("Nothing yet.", "Noch nichts.", "暂无。"),
    "no_exercise": ("Not an exercise of this school", "Keine Übung dieser Schule", "非本校练习项目"),
    "export": ("Export everything stored about this student", "Alles exportieren, was über diese Person gespeichert ist", "导出该学生的全部数据"),
    "delete": ("Delete this student and all sessions", "Diese Person und alle Sitzungen löschen", "删除该学生及全部记录"),
    "confirm": ("Type the pseudonym to confirm", "Zur Bestätigung das Pseudonym eingeben", "输入代号以确认"),
    "download": ("Download", "Herunterladen", "下载"),
    "table_csv": ("Scores (CSV)", "Punkte (CSV)", "成绩 (CSV)"),
    "statements": ("Statements (xAPI)", "Aussagen (xAPI)", "学习记录 (xAPI)"),
    "administration": ("Administration", "Verwaltung", "管理"),
    "benches": ("Benches", "Arbeitsplätze", "练习台"),
    "bench": ("Bench", "Arbeitsplatz", "练习台"),
    "new_bench": ("Add a bench", "Arbeitsplatz hinzufügen", "添加练习台"),
    "bench_secret": ("Copy these two lines into files of the bench; they are shown only once.",
                     "Diese zwei Zeilen in Dateien des Arbeitsplatzes kopieren; sie werden nur einmal gezeigt.", "将以下两行保存到练习台；仅显示一次。"),
    "token": ("Token", "Token", "令牌"),
    "signing_key": ("Signing key", "Signaturschlüssel", "签名密钥"),
    "last_seen": ("Last seen", "Zuletzt gesehen", "最近连接"),
    "import_roster": ("Import a OneRoster 1.2 file (.zip)", "OneRoster-1.2-Datei einlesen (.zip)", "导入 OneRoster 1.2 文件 (.zip)"),
    "new_platform": ("Learning systems (LTI 1.3)", "Lernsysteme (LTI 1.3)", "学习平台 (LTI 1.3)"),
    "platform_settings": ("Settings as JSON: issuer, client_id, deployment, sign_in_url, token_url, keys",
                          "Einstellungen als JSON: issuer, client_id, deployment, sign_in_url, token_url, keys",
                          "JSON 设置：issuer、client_id、deployment、sign_in_url、token_url、keys"),
    "import": ("Import", "Einlesen", "导入"),
    "new_accounts": ("New accounts", "Neue Konten", "新账号"),
    "keep_accounts": ("Keep this list: it is the only link between your identifiers and the pseudonyms, and it shows first passwords only once.",
                      "Bewahren Sie diese Liste auf: Nur sie verbindet Ihre Kennungen mit den Pseudonymen, und sie zeigt die ersten Passwörter nur einmal.",
                      "请保存此列表：它是您的标识与代号之间的唯一对应，初始密码只显示一次。"),
    "new_case": ("Make a case", "Fall erzeugen", "生成病例"),
    "family": ("Family", "Familie", "类别"),
    "seed": ("Number", "Nummer", "编号"),
    "difficulty": ("Difficulty, %", "Schwierigkeit, %", "难度，%"),
    "case_files": ("Files for the bench", "Dateien für den Arbeitsplatz", "练习台文件"),
    "new_class": ("Add a class", "Klasse hinzufügen", "添加班级"),
    "teacher": ("Teacher's user name (empty: a new account)", "Benutzername der Lehrkraft (leer: neues Konto)", "教师用户名（留空则新建账号）"),
    "add_students": ("Add students", "Studierende hinzufügen", "添加学员"),
    "student_lines": ("One student a line: your own identifier (it is not stored), or the pseudonym of a student who is known here",
                      "Eine Person je Zeile: Ihre eigene Kennung (sie wird nicht gespeichert) oder das Pseudonym einer hier bekannten Person",
                      "每行一名学员：您自己的标识（不保存），或本系统已有学员的代号"),
    "no_teacher": ("No teacher has this user name.", "Keine Lehrkraft hat diesen Benutzernamen.", "没有使用该用户名的教师。"),
    "pseudonym": ("Pseudonym", "Pseudonym", "代号"),
    "identifier": ("Identifier", "Kennung", "编号"),
    "not_allowed": ("This page is not for you", "Diese Seite ist nicht für Sie", "您无权访问此页面"),
    "not_allowed_text": ("It does not exist, or your role may not see it.", "Es gibt sie nicht, oder Ihre Rolle darf sie nicht sehen.", "页面不存在，或您的角色无权查看。"),
    "home": ("To the start", "Zum Anfang", "返回首页"),
    "unclaimed": ("Sessions without a known student", "Sitzungen ohne bekannte Person", "未匹配学生的记录"),
    "all_attempts": ("All attempts", "Alle Versuche", "全部记录"),
}
PROGRAM = json.loads(settings.TEXTS.read_text())  # the reports' texts
COLUMN = {language: i for i, language in enumerate(LANGUAGES)}


def say(language, key, **values):
    return TEXTS[key][COLUMN[language]].format(**values)


def item(language, name):
    """Returns the title of a score's item, in the program's words."""
    return PROGRAM.get("score." + name, [name.replace("_", " ")] * 3)[COLUMN[language]]


def place(language, keys):
    """Says a place, whose keys are such as `part.wall side.lingual`."""
    return ", ".join(PROGRAM.get("place." + key, [key] * 3)[COLUMN[language]] for key in keys.split())


def language_of(request):
    chosen = request.COOKIES.get("language", "")
    if chosen in LANGUAGES:
        return chosen
    for wish in request.headers.get("Accept-Language", "").replace(";", ",").split(","):
        if wish.strip()[:2] in LANGUAGES:
            return wish.strip()[:2]
    return "en"
