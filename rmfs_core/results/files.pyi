from rmfs_commands.results.files import (
    AtomicFile as AtomicFile,
)
from rmfs_commands.results.files import (
    clean as clean,
)
from rmfs_commands.results.files import (
    hold as hold,
)
from rmfs_commands.results.files import (
    json_ready as json_ready,
)
from rmfs_commands.results.files import (
    output_folder as output_folder,
)
from rmfs_commands.results.files import (
    removed_if_empty as removed_if_empty,
)
from rmfs_commands.results.files import (
    staged as staged,
)
from rmfs_commands.results.files import (
    to_csv as to_csv,
)
from rmfs_commands.results.files import (
    to_json as to_json,
)
from rmfs_commands.results.files import (
    write_text as write_text,
)
