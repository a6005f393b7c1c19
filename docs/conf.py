# Sphinx's configuration: HTML of these pages by `./dev docs`, which makes those of the headers (Doxyfile) before.
import __future__
import html
import pathlib
import re
import sys
import types
import xml.etree.ElementTree as ET

from docutils import nodes
from sphinx.addnodes import download_reference

DOCS = pathlib.Path(__file__).parent
TREE = DOCS.parent

project = "Recede"
release = re.search(r"^project\(recede VERSION ([\d.]+)", (TREE / "CMakeLists.txt").read_text(), re.M)[1]
copyright = "the Recede authors, MIT licence"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
root_doc = "README"
exclude_patterns = ["headers.dox"]
myst_heading_anchors = 4
# Docstrings have code in single backticks.
default_role = "code"
autodoc_member_order = "groupwise"
autodoc_typehints_format = "short"
autodoc_type_aliases = {"npt.ArrayLike": "ArrayLike"}
html_theme = "alabaster"
html_theme_options = {"page_width": "auto", "body_max_width": "60em", "description": f"Version {release}",
                      "extra_nav_links": {"C++ headers": "cpp/index.html"}}
html_show_sourcelink = False
html_copy_source = False

# The compiled module's stub has its types and docstrings, and stands in for it: nothing has to be built.
sys.path.insert(0, str(TREE / "python"))
stub = TREE / "python/recede/_recede.pyi"
sys.modules["recede._recede"] = compiled = types.ModuleType("recede")
compiled.__version__ = release
exec(compile(stub.read_text(), stub, "exec", __future__.annotations.compiler_flag), vars(compiled))

# By path from the tree's folder. Doxygen gives them as they are in build/release/include/recede/.
HEADER_PAGES = {file.findtext("path").rpartition("/include/recede/")[2] + file.findtext("name"): file.findtext("filename")
                for file in ET.parse(TREE / "build/docs/headers.tag").findall("compound[@kind='file']")}
linked_files, linked_folders = set(), set()


def add_contents(app, page, source):
    """The table of README.md is the table of contents; a page that isn't in it is a warning."""
    if page == root_doc:
        pages = re.findall(r"^\| \[[\w-]+\.md\]\(([\w-]+)\.md\)", source[0], re.M)
        source[0] += "\n```{toctree}\n:hidden:\n" + "\n".join(pages) + "\n```\n"


def shorten_signature(app, what, name, value, options, arguments, result):
    """Stubs leave out defaults that are objects."""
    return arguments and arguments.replace("= Ellipsis", "= ..."), result


def link_files(app, doctree):
    """Links to files of the tree become links to a header's page, or to a page that shows the file."""
    for node in list(doctree.findall(download_reference)):
        path = (DOCS / node["reftarget"]).resolve().relative_to(TREE)
        header = HEADER_PAGES.get(str(path))
        if not header:
            linked_files.add(path)
        link = nodes.reference("", "", *node.children, refuri=f"cpp/{header}" if header else page_name(path) + ".html")
        node.replace_self(link)


def link_folder(app, env, node, content):
    """Links to folders of the tree become links to a list of their files; others stay a warning."""
    path = (DOCS / node["reftarget"]).resolve()
    if not path.is_dir() or not path.is_relative_to(TREE):
        return None
    folder = path.relative_to(TREE)
    linked_folders.add(folder)
    linked_files.update(file.relative_to(TREE) for file in path.iterdir() if file.is_file())
    return nodes.reference("", "", content, refuri=page_name(folder) + ".html")


def page_name(path):
    """All pages are in one folder, from where the navigation's links lead on."""
    return "source-" + "-".join(path.parts)


def source_pages(app):
    for path in linked_files:
        language = {".py": "python", ".cpp": "cpp", ".h": "cpp"}.get(path.suffix, "text")
        yield page(path, app.builder.highlighter.highlight_block((TREE / path).read_text(), language))
    for folder in linked_folders:
        files = sorted(path for path in linked_files if path.parent == folder)
        yield page(folder, "".join(f'<p><a href="{page_name(file)}.html">{file.name}</a></p>' for file in files))


def page(path, body):
    title = html.escape(str(path))
    return page_name(path), {"title": title, "body": f"<h1>{title}</h1>{body}"}, "page.html"


def write_index(app, exception):
    """Folders open at index.html."""
    if not exception:
        text = '<meta http-equiv="refresh" content="0; url=README.html"><a href="README.html">Documentation</a>'
        (pathlib.Path(app.outdir) / "index.html").write_text(text)


def setup(app):
    app.connect("source-read", add_contents)
    app.connect("autodoc-process-signature", shorten_signature)
    app.connect("doctree-read", link_files)
    app.connect("missing-reference", link_folder)
    app.connect("html-collect-pages", source_pages)
    app.connect("build-finished", write_index)
