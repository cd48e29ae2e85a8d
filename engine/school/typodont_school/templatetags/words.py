"""Template tags: texts in the reader's language."""
from django import template
from django.utils.timezone import localtime

from .. import words

register = template.Library()


@register.simple_tag(takes_context=True)
def t(context, key, **values):
    return words.say(context["language"], key, **values)


@register.simple_tag(takes_context=True)
def item(context, name):
    return words.item(context["language"], name)


@register.simple_tag(takes_context=True)
def place(context, keys):
    return words.place(context["language"], keys)


@register.simple_tag(takes_context=True)
def title_of(context, exercise):
    return exercise.title(context["language"]) if exercise else "–"


@register.filter
def number(value, digits=1):
    return f"{value:.{digits}f}" if isinstance(value, (int, float)) else "–"


@register.filter
def moment(value):
    return localtime(value).strftime("%Y-%m-%d %H:%M") if value else "–"


@register.filter
def duration(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
