from django.db import migrations, models


class Migration(migrations.Migration):

    dependencies = [
        ('typodont_school', '0003_rescores'),
    ]

    operations = [
        migrations.AddField(
            model_name='examstart',
            name='announced_s',
            field=models.FloatField(default=0),
        ),
        migrations.AddField(
            model_name='scoreitem',
            name='critical',
            field=models.BooleanField(default=False),
        ),
    ]
